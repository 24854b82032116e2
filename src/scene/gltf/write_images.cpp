// Images, textures and samplers (3.8).
#include <algorithm>

#include "base/error.h"
#include "base/parallel.h"
#include "image/decode.h"
#include "image/encode.h"
#include "scene/gltf/write_parts.h"

namespace parhelion::gltf {

namespace {

struct Encoded {
    std::span<const std::byte> bytes;
    image::Format format = image::Format::Png;
};

const char* media_type(image::Format format) {
    switch (format) {
        case image::Format::Jpeg:
            return "image/jpeg";
        case image::Format::Webp:
            return "image/webp";
        case image::Format::Ktx2:
            return "image/ktx2";
        default:
            return "image/png";
    }
}

const char* file_extension(image::Format format) {
    switch (format) {
        case image::Format::Jpeg:
            return ".jpg";
        case image::Format::Webp:
            return ".webp";
        case image::Format::Ktx2:
            return ".ktx2";
        default:
            return ".png";
    }
}

Encoded kept_file(const Image& image) {
    const Encoded out{*image.encoded, image::detect_format(*image.encoded)};
    switch (out.format) {
        case image::Format::Png:
        case image::Format::Jpeg:
        case image::Format::Webp:
        case image::Format::Ktx2:
            return out;
        default:
            throw Error(ErrorCode::Failed, "its file is of a format that glTF does not have", fmt::format("image '{}'", escape_name(image.name)));
    }
}

std::vector<std::byte> make_png(const Image& image) {
    if (image.format != TexelFormat::Rgba8)
        throw Error(ErrorCode::Failed, "is stored as compressed blocks, and the file that they came from is not there to be written again",
                    fmt::format("image '{}'", escape_name(image.name)), "load the scene with LoadOptions::keep_encoded");
    const auto end = image.texels.begin() + static_cast<std::ptrdiff_t>(level_bytes(image.format, image.width, image.height));
    return image::encode_png(image::Texture8{image.width, image.height, std::vector<uint8_t>(image.texels.begin(), end)});
}

// "F-NAME": NAME without what file systems or URIs might take amiss.
std::string side_stem(const Writer& writer, const Image& image, uint32_t number) {
    std::string out;
    const std::filesystem::path path(image.name);
    for (const char c : path.stem().string()) {
        const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_' || c == '.';
        out += plain ? c : '_';
    }
    out.resize(std::min<size_t>(out.size(), 100));
    if (out.empty()) out = fmt::format("image{}", number);
    const std::string prefix = writer.stem + "-";
    return out.starts_with(prefix) ? out : prefix + out;
}

// No two names differ in case alone: some file systems do not tell them apart.
std::string unique_name(const std::string& stem, const char* extension, std::set<std::string>& taken) {
    for (uint32_t i = 1;; ++i) {
        std::string name = i == 1 ? stem + extension : fmt::format("{}-{}{}", stem, i, extension), lower = name;
        std::ranges::transform(lower, lower.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
        if (taken.insert(lower).second) return name;
    }
}

Json sampler_json(const Sampler& sampler) {
    const auto wrap = [](Wrap w) { return w == Wrap::Repeat ? 10497 : w == Wrap::MirroredRepeat ? 33648 : 33071; };
    const int nearest_or_linear = sampler.min == Filter::Linear ? 1 : 0;
    int min = 9728 + nearest_or_linear;
    if (sampler.mip) min = (*sampler.mip == Filter::Linear ? 9986 : 9984) + nearest_or_linear;
    return {{"magFilter", sampler.mag == Filter::Linear ? 9729 : 9728},
            {"minFilter", min},
            {"wrapS", wrap(sampler.wrap_u)},
            {"wrapT", wrap(sampler.wrap_v)}};
}

// The extension by which a texture names an image that core glTF does not have.
const char* texture_extension(const Json& image) {
    const std::string type = image["mimeType"];
    return type == "image/webp" ? "EXT_texture_webp" : type == "image/ktx2" ? "KHR_texture_basisu" : nullptr;
}

}  // namespace

void write_images(Writer& writer) {
    std::vector<const Image*> images;
    for (const auto& [handle, image] : writer.scene.images()) {
        writer.images.set(handle, static_cast<uint32_t>(images.size()));
        images.push_back(&image);
        if (!image.encoded && image.level_count > 1)
            writer.warn(fmt::format("image '{}' is written as PNG, which has its finest level only", escape_name(image.name)));
    }
    std::vector<std::vector<std::byte>> made(images.size());
    parallel_for(images.size(), 1, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i)
            if (!images[i]->encoded) made[i] = make_png(*images[i]);
    });
    std::set<std::string> taken;
    for (uint32_t i = 0; i < images.size(); ++i) {
        const Image& image = *images[i];
        const Encoded file = image.encoded ? kept_file(image) : Encoded{writer.buffer.keep(std::move(made[i])), image::Format::Png};
        Json json = named(image.name);
        if (writer.stem.empty()) {
            json["mimeType"] = media_type(file.format);
            json["bufferView"] = writer.buffer.add_view(file.bytes, Target::None);
        } else {
            const std::string name = unique_name(side_stem(writer, image, i), file_extension(file.format), taken);
            if (image.name.empty()) json["name"] = name;  // which it would be called by anyway
            json["mimeType"] = media_type(file.format);
            json["uri"] = percent_encode(name);
            writer.side_files.push_back({name, file.bytes});
        }
        writer.push("images", std::move(json));
    }
}

void write_textures(Writer& writer) {
    std::vector<Sampler> samplers;
    for (const auto& [handle, texture] : writer.scene.textures()) {
        auto found = std::ranges::find(samplers, texture.sampler);
        if (found == samplers.end()) {
            writer.push("samplers", sampler_json(texture.sampler));
            samplers.push_back(texture.sampler);
            found = samplers.end() - 1;
        }
        const uint32_t image = writer.images.of(texture.image);
        Json json = named(texture.name);
        json["sampler"] = found - samplers.begin();
        if (const char* extension = texture_extension(writer.root["images"][image])) {
            writer.extend(json, extension, {{"source", image}});
            writer.required.insert(extension);  // there is no other source to fall back to
        } else {
            json["source"] = image;
        }
        writer.textures.set(handle, writer.push("textures", std::move(json)));
    }
}

}  // namespace parhelion::gltf
