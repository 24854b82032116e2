#pragma once
// What is known of whole classes of devices: how each traces fastest, and whether it draws faster than that. One table, in device_class.cpp.
#include <span>
#include <string_view>

#include "gpu/device.h"

namespace parhelion::gpu {

// Layout of our own acceleration structure's nodes (shared/bvh.h). Auto: what is fastest on devices of this class.
enum class NodeLayout : uint32_t { Auto, Binary, Four, Compact };
std::string_view node_layout_name(NodeLayout layout);

struct DeviceClass {
    std::string_view name;
    bool (*holds)(const DeviceCaps& caps);
    TraceWay way;       // what `--trace auto` takes
    NodeLayout layout;  // of our own structure; not Auto
    bool walks_in_rounds;  // its traversal's loop: BvhLoop::Rounds, else Descend
    uint32_t wavefront_slots;  // paths of the wavefront at a time
    bool draws_pixels;         // what `gbuffer.mode=auto` takes: raster, else a ray a pixel
};

// The first that holds is a device's class; the last holds for every device.
std::span<const DeviceClass> device_classes();
const DeviceClass& device_class(const DeviceCaps& caps);

}  // namespace parhelion::gpu
