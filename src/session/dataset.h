#pragma once
// `render --dataset`: a folder of frames, each as reconstruction gets it and as the reference draws it, with dataset.json, which says what they
// are. A frame is there once dataset.json names it: that is written after the frame's files, so a folder is whole whenever a run ends. The
// same command goes on with a folder that it began.
#include <filesystem>
#include <map>

#include <nlohmann/json.hpp>

#include "image/image.h"
#include "renderers/kept_input.h"
#include "session/job.h"

namespace parhelion {

// Throws Error unless the folder can become a dataset or may be one: it is missing and can be made, is empty, or has a dataset.json. Before
// any work.
void check_dataset_folder(const std::filesystem::path& folder);

// What all frames have in common: scene, settings, conventions. `reference_hash`: hash_render() of the references.
nlohmann::ordered_json describe_dataset(const RenderOptions& options, const RenderReport& report, uint64_t reference_hash);

class Dataset {
public:
    // Makes the folder, or goes on with the one that is there. Throws Error if that holds another dataset, or is damaged.
    Dataset(std::filesystem::path folder, const nlohmann::ordered_json& about);

    // Named, and its files are there.
    bool has(uint64_t frame) const;
    size_t size() const { return frames_.size(); }
    struct Pair {
        uint64_t frame = 0;
        double time = 0;  // seconds on the scene's clock
        InputReadback input;
        image::ImageF layers, reference;  // the first without channels: takes the input's layers
    };
    void add(Pair pair, const OutputOptions& output);

private:
    void read();
    void write() const;

    std::filesystem::path folder_;
    nlohmann::ordered_json about_;
    std::map<uint64_t, nlohmann::ordered_json> frames_;
};

}  // namespace parhelion
