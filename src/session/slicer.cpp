#include "session/slicer.h"

#include <algorithm>
#include <cmath>

namespace parhelion {

namespace {
constexpr double kMaxGrowth = 4;  // of a slice from one to the next: a quick first slice proves little
}

Slicer::Slicer(Size2 size, IndexRange samples, double target_seconds, uint64_t first_slice_work, uint64_t most_work, uint64_t most_samples)
    : size_(size),
      samples_(samples),
      target_seconds_(target_seconds),
      most_work_(static_cast<double>(most_work)),
      most_samples_(static_cast<double>(most_samples)),
      budget_(static_cast<double>(std::min(first_slice_work, most_work))),
      sample_(samples.begin),
      pass_begin_(samples.begin),
      total_work_(double(size.width) * size.height * double(samples.end - samples.begin)) {}

std::optional<shared::Slice> Slicer::next() {
    const double frame = double(size_.width) * size_.height;
    if (row_ == 0) {
        if (sample_ >= samples_.end) return std::nullopt;
        const uint64_t block_end = (sample_ / shared::kSamplesPerBlock + 1) * shared::kSamplesPerBlock;
        const uint64_t wanted = std::max<uint64_t>(1, static_cast<uint64_t>(std::min(budget_ / frame, most_samples_)));
        pass_begin_ = sample_;
        sample_ = std::min({sample_ + wanted, block_end, samples_.end});
    }
    const auto count = static_cast<uint32_t>(sample_ - pass_begin_);
    const double wanted_rows = std::clamp(std::floor(budget_ / (double(size_.width) * count)), 1.0, double(size_.height - row_));
    shared::Slice slice{row_, static_cast<uint32_t>(wanted_rows), static_cast<uint32_t>(pass_begin_), count};
    row_ += slice.row_count;
    if (row_ == size_.height) row_ = 0;
    done_work_ += double(size_.width) * slice.row_count * count;
    return slice;
}

void Slicer::measured(const shared::Slice& slice, double seconds) {
    const double work = double(size_.width) * slice.row_count * slice.sample_count;
    const double wanted = work * target_seconds_ / std::max(seconds, 1e-6);
    budget_ = std::clamp(wanted, budget_ / kMaxGrowth, work * kMaxGrowth);
    budget_ = std::clamp(budget_, double(size_.width), std::max(most_work_, double(size_.width)));
}

std::vector<uint64_t> Slicer::samples_of_rows() const {
    std::vector<uint64_t> counts(size_.height, whole_samples());
    std::fill_n(counts.begin(), row_, sample_);
    return counts;
}

bool Slicer::inside_block_end() const { return row_ != 0 && (sample_ % shared::kSamplesPerBlock == 0 || sample_ == samples_.end); }

}  // namespace parhelion
