#pragma once
// Finds missing synchronisation. Knows every access of every pass to every resource (buffers reached by address, images,
// acceleration structures, indirect arguments) and every barrier; says which accesses are not ordered. Frame plans its
// barriers by asking it, and a test that leaves a barrier out sees it complain. The validation layers cannot do this for
// buffer addresses.
//
// The model is Vulkan's with global memory barriers: a barrier (before -> after) orders every earlier access whose use is in
// `before` (directly, or through an earlier barrier's `after`: a chain) in front of later accesses whose use is in `after`,
// and makes earlier writes visible to them.
#include <cstdint>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "gpu/resources.h"

namespace parhelion {

using UseMask = uint32_t;
constexpr UseMask use_bit(gpu::Use use) { return 1u << static_cast<uint32_t>(use); }

struct Access {
    const void* resource = nullptr;  // Buffer::id(), Image::id(), AccelStruct::id()
    gpu::Use use = gpu::Use::ComputeRead;
    const std::string* name = nullptr;  // the resource's, for messages and listings
};

// What one access still has to wait for: uses of earlier accesses that no barrier orders before it.
struct Hazard {
    UseMask before = 0;
    bool exists() const { return before != 0; }
};

class HazardTracker {
public:
    // What `access` conflicts with, given all accesses and barriers so far: read after write, write after write, write after read.
    Hazard find(const Access& access);
    void add_barrier(UseMask before, UseMask after) { barriers_.push_back({before, after}); }
    void add_access(const Access& access) { add_accesses({&access, 1}); }
    // Of passes that run beside each other: none of them is ordered before another.
    void add_accesses(std::span<const Access> accesses);
    void forget(const void* resource) { states_.erase(resource); }  // a resource that no longer exists
    void compact();                                                  // bounds the memory of long runs

private:
    struct Barrier {
        UseMask before, after;
    };
    struct Pending {
        UseMask uses = 0;     // uses of the accesses themselves
        UseMask ordered = 0;  // uses that barriers put after them
    };
    struct State {
        Pending write, reads;
        size_t next_barrier = 0;  // barriers below this index are applied
    };
    State& current(const void* resource);
    std::unordered_map<const void*, State> states_;
    std::vector<Barrier> barriers_;
};

}  // namespace parhelion
