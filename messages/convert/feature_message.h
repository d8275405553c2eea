// The features of an image: feature_frame_t <-> FeatureFrame, exact both ways.
#pragma once

#include <eifmap/feature_frame_t.hpp>

#include "convert/bytes.h"
#include "frame.h"

namespace eifmap {

// Throws std::invalid_argument when the descriptors are not kDescriptorSize bytes a keypoint.
feature_frame_t to_message(const FeatureFrame& frame);

// Refuses: kMalformedMessage (sizes, name, time), kUnknownExtractor, kBadFeatures (not finite,
// outside the image, sigma or scale not positive, no sign).
Decoded<FeatureFrame> decode_features(Bytes bytes);

}  // namespace eifmap
