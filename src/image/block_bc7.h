#pragma once
// Inside the image library: one BC7 block.
#include <cstdint>

namespace parhelion::image {

// 16 bytes to 16 RGBA texels, exactly as the format defines them; a reserved block is all zeros.
void decode_bc7(const uint8_t* block, uint8_t* rgba);

}  // namespace parhelion::image
