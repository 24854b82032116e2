#include "scene/gltf_images.h"

#include <algorithm>
#include <atomic>
#include <chrono>

#include "base/error.h"
#include "base/parallel.h"
#include "image/decode.h"

namespace parhelion {

namespace {

struct Job {
    uint32_t index;
    std::string name, where;
    SceneFiles::Bytes kept;  // a file's bytes live as long as the job
    std::span<const std::byte> bytes;
    image::Texture8 decoded;
    bool done = false;
};

Job open_image(GltfDocument& document, uint32_t index) {
    const JsonRef json = document.root().at("images")[index];
    Job job{.index = index, .name = json.string("name"), .where = json.where()};
    const std::optional<JsonRef> uri = json.find("uri"), view = json.find("bufferView");
    if (uri && view) json.fail("has both a uri and a bufferView");
    if (uri) {
        job.kept = document.files().read_uri(uri->as_string(), uri->where());
        job.bytes = *job.kept;
        if (!is_data_uri(uri->as_string())) {
            job.where += fmt::format(" ('{}')", escape_name(uri->as_string(), 100));
            if (job.name.empty()) job.name = uri->as_string();
        }
    } else if (view) {
        job.bytes = document.view(*view).bytes;
    } else {
        json.fail("has neither a uri nor a bufferView");
    }
    return job;
}

void decode(Job& job, SceneFiles& files, uint64_t max_bytes) {
    image::DecodeLimits limits;
    limits.max_bytes = std::min(limits.max_bytes, max_bytes);
    switch (const image::Format format = image::detect_format(job.bytes)) {
        case image::Format::Png:
            job.decoded = image::decode_png(job.bytes, limits, job.where);
            break;
        case image::Format::Jpeg:
            job.decoded = image::decode_jpeg(job.bytes, limits, job.where);
            break;
        default:
            throw Error(ErrorCode::Failed,
                        format == image::Format::Unknown
                            ? "is no image of a known format"
                            : fmt::format("is a {} image, which textures cannot be", image::format_name(format)),
                        job.where, "glTF textures are PNG or JPEG");
    }
    files.charge(job.decoded.rgba.size(), job.where);
    job.done = true;
}

}  // namespace

std::map<uint32_t, Handle<Image>> add_images(GltfDocument& document, SceneEdit& edit, const std::set<uint32_t>& images) {
    std::vector<Job> jobs;
    for (const uint32_t index : images) jobs.push_back(open_image(document, index));

    // Several at once, each within its share of the budget; what that refuses (or is broken) has its turn alone, with all of it. The first
    // broken one will end it all then: a second of work on those that fail is enough, for a file may name thousands.
    SceneFiles& files = document.files();
    using Clock = std::chrono::steady_clock;
    std::atomic<Clock::rep> wasted = 0;
    parallel_for(jobs.size(), 1, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end && wasted < Clock::duration(std::chrono::seconds(1)).count(); ++i) {
            const Clock::time_point start = Clock::now();
            try {
                decode(jobs[i], files, files.budget_left() / (2 * hardware_threads()));
            } catch (const Error&) {
                jobs[i].decoded = {};
                wasted += (Clock::now() - start).count();
            }
        }
    });
    std::map<uint32_t, Handle<Image>> out;
    for (Job& job : jobs) {
        if (!job.done) decode(job, files, files.budget_left());
        out[job.index] = edit.add(Image{
            .name = std::move(job.name), .width = job.decoded.width, .height = job.decoded.height, .texels = std::move(job.decoded.rgba)});
        job.kept.reset();
    }
    return out;
}

}  // namespace parhelion
