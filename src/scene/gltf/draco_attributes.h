#pragma once
// Decoders of Draco's attributes that look at the counts which Draco believes (seen in 1.5.5).
#include <memory>
#include <string>

#include <draco/compression/attributes/attributes_decoder_interface.h>

namespace parhelion {

// What stands in for `made`, a decoder that a draco::MeshDecoder has just created for some attributes: it does the same, but refuses
// more turns of texture coordinates than `corners`, three times the number of triangles. A count of up to 2^32 of them is
// decoded bit by bit from data that ended long ago: seconds and hundreds of MB for each attribute of a tiny file.
// `problem`, which must outlive the decoder, says what was refused. Empties `made`.
std::unique_ptr<draco::AttributesDecoderInterface> limited_attributes_decoder(draco::AttributesDecoderInterface& made, uint64_t corners,
                                                                             std::string& problem);

}  // namespace parhelion
