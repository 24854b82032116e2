#include "renderers/reference.h"

namespace parhelion {

passes::PathTraceOptions trace_options(const ViewDesc& view) {
    return {.ray_cones = view.texture_lod == TextureLod::Cone, .shade_in_hit = view.shade_in == ShadeIn::ClosestHit};
}

void check_reference(const ViewDesc& view, bool pipeline) { passes::check_shading(trace_options(view), pipeline); }

void record_reference(Frame& frame, const SceneGpu& scene, gpu::TraceWay way, View& view, const shared::Slice& slice, bool ends_range) {
    begin_slice(frame, scene, way, view, slice);
    passes::path_trace(frame, scene, way, view.film(), slice, trace_options(view.desc()));
    end_slice(frame, view, slice, ends_range);
}

}  // namespace parhelion
