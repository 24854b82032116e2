#pragma once
// Pearson's correlation coefficient of two equally long lists.
#include <cmath>
#include <vector>

namespace parhelion::testing {

template <class T>
double correlation(const std::vector<T>& a, const std::vector<T>& b) {
    double mean_a = 0, mean_b = 0, ab = 0, aa = 0, bb = 0;
    for (size_t i = 0; i < a.size(); ++i) mean_a += a[i], mean_b += b[i];
    mean_a /= double(a.size()), mean_b /= double(b.size());
    for (size_t i = 0; i < a.size(); ++i) {
        const double da = a[i] - mean_a, db = b[i] - mean_b;
        ab += da * db, aa += da * da, bb += db * db;
    }
    return ab / std::sqrt(aa * bb);
}

}  // namespace parhelion::testing
