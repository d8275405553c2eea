// Pieces of what the pages are sent.
#pragma once

#include <eifmap/status_t.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "client/view/shown_map.h"
#include "client/view/shown_path.h"
#include "convert/camera_message.h"
#include "frame.h"
#include "map_view.h"

namespace eifmap::view_json {

using Json = nlohmann::ordered_json;

// Rounded to 1e-5; null when it is not finite.
Json number(double value);

// {position, quaternion: wxyz, ellipsoid: the 3-sigma half axes of the position, three vectors one
// after the other, or null; sigmas: the same axes' standard deviations, falling, or null}
Json pose(const FrameResult& result);

Json status(const status_t& status);
Json lens(const NamedCamera& camera);  // {width, height px, half_width, half_height at depth 1}
Json features(const FeatureFrame& features);  // {width, height px, points: [u, v, sign] * n}
Json path(const ShownPath& path, std::size_t from);

void append(Json& list, std::int64_t id, const ShownKeyframe& keyframe);
void append(Json& list, std::int64_t id, const ShownLandmark& landmark);

// Texts come from the network: what is no UTF-8 is replaced, not thrown about.
std::string text_of(const Json& json);

}  // namespace eifmap::view_json
