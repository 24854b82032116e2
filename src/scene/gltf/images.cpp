#include "scene/gltf/images.h"

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
    image::Texels decoded;
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
    job.decoded = image::decode_texels(job.bytes, limits, job.where);
    files.charge(job.decoded.bytes.size(), job.where);
    job.done = true;
}

std::string_view mime_type(image::Format format) {
    switch (format) {
        case image::Format::Png: return "image/png";
        case image::Format::Jpeg: return "image/jpeg";
        case image::Format::Webp: return "image/webp";
        case image::Format::Ktx2: return "image/ktx2";
        default: return {};
    }
}

void check_mime_type(GltfDocument& document, const Job& job) {
    const JsonRef json = document.root().at("images")[job.index];
    const std::string stated = json.string("mimeType");
    const image::Format format = image::detect_format(job.bytes);
    const std::string_view found = mime_type(format);
    if (stated.empty() || found.empty() || stated == found) return;
    document.warn(json, fmt::format("its mimeType is '{}', but it is a {} image and was read as one", escape_name(stated, 40), image::format_name(format)));
}

Image to_image(Job& job, SceneFiles& files, bool keep_encoded) {
    Image image{.name = std::move(job.name), .width = job.decoded.width, .height = job.decoded.height, .format = job.decoded.format,
                .level_count = job.decoded.level_count, .texels = std::move(job.decoded.bytes)};
    if (!keep_encoded) return image;
    files.charge(job.bytes.size(), job.where);
    image.encoded = std::make_shared<const std::vector<std::byte>>(job.bytes.begin(), job.bytes.end());
    return image;
}

}  // namespace

std::map<uint32_t, Handle<Image>> add_images(GltfDocument& document, SceneEdit& edit, const std::set<uint32_t>& images, bool keep_encoded) {
    std::vector<Job> jobs;
    for (const uint32_t index : images) {
        jobs.push_back(open_image(document, index));
        check_mime_type(document, jobs.back());
    }

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
        out[job.index] = edit.add(to_image(job, files, keep_encoded));
        job.kept.reset();
    }
    return out;
}

std::optional<std::string> obstacle_of_image(GltfDocument& document, uint32_t index) {
    const Job job = open_image(document, index);
    if (image::detect_format(job.bytes) != image::Format::Ktx2) return std::nullopt;
    return image::ktx2_obstacle(job.bytes, job.where);
}

std::optional<uint32_t> image_of_texture(GltfDocument& document, const JsonRef& texture) {
    const auto source_of = [&](std::string_view extension) -> std::optional<uint32_t> {
        const std::optional<JsonRef> owner = texture.extension(extension);
        const std::optional<JsonRef> source = owner ? owner->find("source") : std::nullopt;
        return source ? std::optional(source->as_index_of("images")) : std::nullopt;
    };
    const std::optional<JsonRef> plain = texture.find("source");
    const std::optional<uint32_t> ktx2 = source_of("KHR_texture_basisu"), webp = source_of("EXT_texture_webp");
    const std::optional<uint32_t> other = webp ? webp : plain ? std::optional(plain->as_index_of("images")) : std::nullopt;
    if (!ktx2) {
        if (!other) document.warn(texture, "has no source that is read and is left out");
        return other;
    }
    const std::optional<std::string> obstacle = obstacle_of_image(document, *ktx2);
    if (!obstacle) return ktx2;
    constexpr std::string_view kRemedy = "encode it again as KTX2 with BC7, or as PNG";
    if (other) {
        document.warn(fmt::format("KTX2 images with {} are not read; the images that stand in for them are shown", *obstacle));
        return other;
    }
    const std::vector<std::string>& required = document.extensions_required();
    if (std::find(required.begin(), required.end(), "KHR_texture_basisu") != required.end())
        texture.fail(fmt::format("its image is a KTX2 with {}, which is not supported", *obstacle), std::string(kRemedy));
    document.warn(texture, fmt::format("its image is a KTX2 with {}, which is not supported; the texture is left out ({})", *obstacle, kRemedy));
    return std::nullopt;
}

}  // namespace parhelion
