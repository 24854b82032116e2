// Every malformed file of the assets folder (PARHELION_ASSETS), and its complete models, against the verdict of the Khronos glTF validator.
// What is no agreement must be explained in tests/malformed/differences.tsv. The built-in twins are the gltf tests, which make a broken file
// of each kind.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/file.h"
#include "scene/load.h"

namespace parhelion::malformed_assets_test {

namespace fs = std::filesystem;

namespace {

// Of models that are broken on purpose, or that test a loader. All others are complete models.
const std::set<std::string> kMalformedGroups = {"validator_dev",  "magnum_dev",             "gag_negative_dev",   "assimp_bad_dev",
                                                "tinygltf_bad_dev", "cgltf_fastgltf_fuzz_dev", "fastgltf_tests_dev", "meshopt_fuzz_dev"};

using Codes = std::set<std::string>;

std::vector<std::vector<std::string>> read_table(const std::string& name) {
    std::istringstream text(read_text_file(fs::path(PARHELION_SOURCE_DIR) / "tests" / "malformed" / name, 1 << 24));
    std::vector<std::vector<std::string>> rows;
    for (std::string line; std::getline(text, line);) {
        if (line.empty() || line[0] == '#') continue;
        std::istringstream fields(line);
        rows.emplace_back();
        for (std::string field; std::getline(fields, field, '\t');) rows.back().push_back(field);
    }
    return rows;
}

// The validator's errors: those of the report beside the file, or of our run of the validator (tests/malformed/verdicts.tsv).
struct Verdicts {
    std::map<std::string, Codes> codes;
    Verdicts() {
        for (const std::vector<std::string>& row : read_table("verdicts.tsv")) {
            Codes& of_file = codes[row.at(0)];
            std::istringstream list(row.size() > 1 ? row[1] : "");
            for (std::string code; std::getline(list, code, ',');) of_file.insert(code);
        }
    }
    Codes of(const fs::path& root, const std::string& file) const {
        const fs::path report = root / (file + ".report.json");
        if (!fs::exists(report)) return codes.at(file);
        Codes out;
        const nlohmann::json json = nlohmann::json::parse(read_text_file(report, 1 << 24));
        for (const nlohmann::json& message : json["issues"]["messages"])
            if (message["severity"] == 0) out.insert(message["code"].get<std::string>());
        return out;
    }
};

struct Outcome {
    bool refused = false, extension = false, warned = false, empty = false;
    std::string text;
};

// Warnings that say nothing about an error of the file.
bool tells_of_an_error(const std::string& warning) {
    for (const char* other : {"the scene is empty", "has no scene", "is not drawn", "are not drawn", "without area"})
        if (warning.find(other) != std::string::npos) return false;
    return true;
}

Outcome load_outcome(const fs::path& path) {
    try {
        const LoadedScene loaded = load_scene(path.string());
        const std::vector<std::string>& warnings = loaded.scene.source().warnings;
        const auto told = std::find_if(warnings.begin(), warnings.end(), tells_of_an_error);
        return {.warned = told != warnings.end(), .empty = loaded.scene.nodes().size() == 0, .text = told != warnings.end() ? *told : "loads"};
    } catch (const Error& error) {
        return {.refused = true, .extension = error.problem.find("which is not supported") != std::string::npos, .text = error.line};
    }
}

struct Count {
    int refused = 0, warned = 0, loaded = 0, unsupported = 0, unseen = 0, stricter = 0, laxer = 0;
};

class Comparison {
public:
    explicit Comparison(fs::path root) : root_(std::move(root)) {
        for (const std::vector<std::string>& row : read_table("differences.tsv"))
            (row.at(0) == "laxer" ? laxer_ : stricter_).insert(row.at(1));
    }

    void check(const std::string& file) {
        seen_.insert(file);
        Count& count = counts_[file.substr(0, file.find('/'))];
        const auto begin = std::chrono::steady_clock::now();
        const Outcome outcome = load_outcome(root_ / file);
        const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        if (kMalformedGroups.contains(file.substr(0, file.find('/')))) {
            EXPECT_LT(seconds, 10.0) << file;
        }
        const Codes codes = verdicts_.of(root_, file);
        const bool unexplained_code = std::any_of(codes.begin(), codes.end(), [&](const std::string& code) { return !laxer_.contains(code); });
        if (outcome.refused && outcome.extension) {
            ++count.unsupported;
        } else if (!codes.empty() && (outcome.refused || outcome.warned)) {
            ++(outcome.refused ? count.refused : count.warned);
        } else if (codes.empty() && !outcome.refused) {
            ++count.loaded;
        } else if (codes.empty()) {
            ++count.stricter;
            differing_.insert(file);
            if (!stricter_.contains(file)) unexplained(file, codes, outcome);
        } else if (outcome.empty) {
            ++count.unseen;  // nothing is drawn: only what the scene shows is read
        } else {
            ++count.laxer;
            differing_.insert(file);
            if (unexplained_code && !laxer_.contains(file)) unexplained(file, codes, outcome);
        }
    }

    // Rows of files that do not differ any more are told, so that they get removed.
    void print() const {
        for (const std::set<std::string>* list : {&laxer_, &stricter_})
            for (const std::string& name : *list)
                if (name.find('/') != std::string::npos && seen_.contains(name) && !differing_.contains(name)) fmt::print("differs no more: {}\n", name);
        fmt::print("{:28} {:>8} {:>8} {:>8} {:>12} {:>8} {:>9} {:>6}\n", "", "refused", "warned", "loaded", "unsupported", "unseen", "stricter", "laxer");
        for (const auto& [group, c] : counts_)
            fmt::print("{:28} {:8} {:8} {:8} {:12} {:8} {:9} {:6}\n", group, c.refused, c.warned, c.loaded, c.unsupported, c.unseen, c.stricter, c.laxer);
    }

private:
    static void unexplained(const std::string& file, const Codes& codes, const Outcome& outcome) {
        std::string list;
        for (const std::string& code : codes) list += code + " ";
        ADD_FAILURE() << file << "\n  validator: " << (list.empty() ? "no errors" : list) << "\n  here:      " << outcome.text;
    }

    fs::path root_;
    Verdicts verdicts_;
    std::set<std::string> laxer_, stricter_, seen_, differing_;
    std::map<std::string, Count> counts_;
};

std::vector<std::string> models(const fs::path& root, bool malformed) {
    std::vector<std::string> out;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root)) {
        const std::string extension = entry.path().extension().string(), file = fs::relative(entry.path(), root).string();
        if (extension != ".gltf" && extension != ".glb") continue;
        if (kMalformedGroups.contains(file.substr(0, file.find('/'))) == malformed) out.push_back(file);
    }
    std::sort(out.begin(), out.end());
    return out;
}

fs::path assets() {
    const char* folder = std::getenv("PARHELION_ASSETS");
    return folder == nullptr || !fs::exists(folder) ? fs::path() : fs::path(folder);
}

}  // namespace

// PARHELION_ALL_MODELS=1: the complete models too, which takes longer.
TEST(MalformedAssets, are_refused_or_warned_as_the_validator_asks_within_ten_seconds) {
    if (assets().empty()) GTEST_SKIP() << "PARHELION_ASSETS names no folder";
    Comparison comparison(assets());
    for (const std::string& file : models(assets(), true)) comparison.check(file);
    if (std::getenv("PARHELION_ALL_MODELS") != nullptr)
        for (const std::string& file : models(assets(), false)) comparison.check(file);
    comparison.print();
}

}  // namespace parhelion::malformed_assets_test
