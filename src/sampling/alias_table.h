#pragma once
// Alias tables: an index with given probabilities from one row of a table. Walker 1977, "An Efficient Method for Generating
// Discrete Random Variables with General Distributions"; construction after Vose 1991. The device draws with sample_alias() of
// lib/alias.glsl, which compiles as C++ too.
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

namespace parhelion::sampling {

struct AliasRow {
    float probability = 0;  // of keeping the row's own index: a multiple of 2^-24, which is what random numbers can tell apart
    uint32_t alias = 0;     // given otherwise
};

class AliasTable {
public:
    static constexpr uint32_t kMaxRows = 1u << 24;

    // The table of non-negative weights of any scale; the same on every machine. No weights, or none above 0, make an empty
    // table. Throws Error naming `where` for a weight that is negative, infinite or NaN, and for more than kMaxRows weights.
    explicit AliasTable(std::span<const double> weights, std::string_view where = "alias table");

    bool empty() const { return entries_.empty(); }
    const std::vector<AliasRow>& entries() const { return entries_; }
    // With which probability the table gives each index: of these very rows, rounded once to float. It is 0 just if the weight
    // is 0; the least positive one is 2^-24 / rows, so no light is lost however dim.
    const std::vector<float>& pmf() const { return pmf_; }

private:
    void pair_rows(std::span<const double> weights, std::vector<double> mass);
    void sum_pmf();

    std::vector<AliasRow> entries_;
    std::vector<float> pmf_;
};

}  // namespace parhelion::sampling
