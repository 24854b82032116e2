// Writes src/sampling/sobol_data.cpp: a polynomial and initial direction numbers for each dimension of the Sobol sequence.
//     g++ -std=c++20 -O2 -Isrc -Ishaders tools/make_sobol.cpp -o make_sobol && ./make_sobol > src/sampling/sobol_data.cpp
// The polynomials are all primitive ones over GF(2) in order of degree (Sobol 1967). The initial numbers are searched by a seeded
// generator, dimension after dimension. The criterion is that of Joe and Kuo 2008, "Constructing Sobol Sequences with Better
// Two-Dimensional Projections", cut to what a path needs: the quality parameter t of the projections on pairs of dimensions, but
// of near ones only (they are used together), for as many points as pixels get. Among equals, and ahead of them, it asks that
// eight neighbours have Sobol's property A (Sobol 1976): 2^8 points put one into each of the 2^8 orthants.
#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstdio>
#include <random>
#include <vector>

#include "sampling/sobol.h"

using parhelion::sampling::expand_directions;
using parhelion::sampling::kSobolMaxDegree;
using parhelion::sampling::SobolDimension;
using parhelion::sampling::SobolDirections;

namespace {

constexpr int kNeighbours = 8;       // pairs (j, j - 1) ... (j, j - 8) count, the nearest most
constexpr int kMaxLogPoints = 12;    // nets of 2^2 ... 2^12 points
constexpr int kCandidates = 20000;    // per dimension
constexpr uint32_t kSeed = 2020;

// Is x a generator of the field GF(2)[x] / polynomial?
bool is_primitive(uint32_t polynomial, uint32_t degree) {
    const uint32_t order = (1u << degree) - 1;
    uint32_t power = 1;
    for (uint32_t k = 1; k <= order; ++k) {
        power <<= 1;
        if (power >> degree) power ^= polynomial;
        if (power == 1) return k == order;
    }
    return false;
}

// Row r of a generator matrix: bit k says whether index bit k flips the r-th bit of the coordinate after the point.
using Matrix = std::vector<uint32_t>;
Matrix rows_of(const SobolDirections& v) {
    Matrix rows(32, 0);
    for (uint32_t k = 0; k < 32; ++k)
        for (uint32_t r = 0; r < 32; ++r) rows[r] |= ((v[k] >> (31 - r)) & 1u) << k;
    return rows;
}

// A growing set of independent vectors over GF(2), each reduced to its own leading bit.
struct Basis {
    uint32_t lead[32] = {};
    bool add(uint32_t row) {
        while (row != 0) {
            const int top = std::bit_width(row) - 1;
            if (lead[top] == 0) {
                lead[top] = row;
                return true;
            }
            row ^= lead[top];
        }
        return false;
    }
};

// Quality parameter of the 2^m points of a pair: every elementary interval of area 2^(t - m) holds 2^t of them.
int net_t(const Matrix& a, const Matrix& b, int m) {
    const uint32_t mask = (1u << m) - 1;
    int strength = m;  // largest r such that any r1 + r2 = r leading rows are independent
    Basis first;
    for (int r1 = 0; r1 <= strength; ++r1) {
        if (r1 > 0 && !first.add(a[r1 - 1] & mask)) return m - (r1 - 1 < strength ? r1 - 1 : strength);
        Basis both = first;
        int r2 = 0;
        while (r1 + r2 < strength && both.add(b[r2] & mask)) ++r2;
        strength = std::min(strength, r1 + r2);
    }
    return m - strength;
}

// 0: property A holds for the last eight dimensions; else how many leading bits depend on the others.
int property_a_deficit(const std::vector<Matrix>& chosen, const Matrix& next) {
    const int count = std::min<int>(kNeighbours, static_cast<int>(chosen.size()) + 1);
    const uint32_t mask = (1u << count) - 1;
    Basis basis;
    int rank = basis.add(next[0] & mask);
    for (int k = 1; k < count; ++k) rank += basis.add(chosen[chosen.size() - k][0] & mask);
    return count - rank;
}

double cost(const std::vector<Matrix>& chosen, const Matrix& next, double best) {
    double sum = 1000.0 * property_a_deficit(chosen, next);
    for (int k = 1; k <= kNeighbours && k <= static_cast<int>(chosen.size()) && sum < best; ++k)
        for (int m = 2; m <= kMaxLogPoints; ++m) sum += static_cast<double>(1 << net_t(chosen[chosen.size() - k], next, m)) / k;
    return sum;
}

// Initial numbers are free: odd, m_k < 2^k. Small degrees are tried many times over, which does no harm.
SobolDimension search(uint32_t polynomial, uint32_t degree, const std::vector<Matrix>& chosen, std::mt19937& random) {
    SobolDimension best{};
    double best_cost = 1e300;
    for (int candidate = 0; candidate < kCandidates; ++candidate) {
        SobolDimension dimension{.polynomial = polynomial};
        for (uint32_t k = 0; k < degree; ++k) dimension.initial[k] = static_cast<uint16_t>((random() & ((1u << (k + 1)) - 1)) | 1u);
        const double value = cost(chosen, rows_of(expand_directions(dimension)), best_cost);
        if (value >= best_cost) continue;
        best = dimension;
        best_cost = value;
    }
    std::fprintf(stderr, "dimension %zu: degree %u, cost %.1f\n", chosen.size(), degree, best_cost);
    return best;
}

void print(const SobolDimension& dimension) {
    std::printf("    {0x%X, {", dimension.polynomial);
    const int degree = std::bit_width(dimension.polynomial) - 1;
    for (int k = 0; k < degree; ++k) std::printf("%s%u", k ? ", " : "", dimension.initial[k]);
    std::printf("}},\n");
}

}  // namespace

int main() {
    std::mt19937 random(kSeed);
    std::printf("// Written by tools/make_sobol.cpp: polynomial and initial direction numbers of each dimension.\n");
    std::printf("#include \"sampling/sobol.h\"\n\nnamespace parhelion::sampling {\n\n");
    std::printf("const std::array<SobolDimension, shared::kSobolDimensions> kSobolData{{\n");
    const SobolDimension first{};
    print(first);
    std::vector<Matrix> chosen{rows_of(expand_directions(first))};
    for (uint32_t degree = 1; degree <= kSobolMaxDegree; ++degree) {
        for (uint32_t middle = 0; middle < (1u << (degree - 1)) && chosen.size() < parhelion::shared::kSobolDimensions; ++middle) {
            const uint32_t polynomial = (1u << degree) | (middle << 1) | 1u;
            if (!is_primitive(polynomial, degree)) continue;
            const SobolDimension dimension = search(polynomial, degree, chosen, random);
            print(dimension);
            chosen.push_back(rows_of(expand_directions(dimension)));
        }
    }
    std::printf("}};\n\n}  // namespace parhelion::sampling\n");
    return chosen.size() == parhelion::shared::kSobolDimensions ? 0 : 1;
}
