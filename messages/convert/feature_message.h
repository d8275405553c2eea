// The features of an image: feature_frame_t <-> FeatureFrame, exact both ways.
#pragma once

#include <eifmap/feature_frame_t.hpp>

#include "frame.h"
#include "wire/bytes.h"

namespace eifmap {

// A frame, or one of the parts that it was sent in: feature_parts.h.
struct FeaturePart {
  FeatureFrame frame;
  int part = 0, num_parts = 1;
};

// Throws std::invalid_argument when the descriptors are not kDescriptorSize bytes a keypoint.
feature_frame_t to_message(const FeatureFrame& frame);

// Refuses: kMalformedMessage (sizes, name, time, numbers of parts), kUnknownExtractor, kBadFeatures
// (not finite, outside the image, sigma or scale not positive, no sign).
Decoded<FeaturePart> decode_feature_part(Bytes bytes);

// The same of a whole frame; a part of one is a kMalformedMessage.
Decoded<FeatureFrame> decode_features(Bytes bytes);

// Whether the bytes, if they are a feature frame at all, say that they are one of several parts,
// and that they are the first one.
bool is_part_of_features(Bytes bytes);
bool is_first_part(Bytes bytes);

}  // namespace eifmap
