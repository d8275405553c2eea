#include "server/config.h"

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <vector>

#include "bus/link.h"
#include "program/nearest_name.h"
#include "server/config_fields.h"
#include "wire/channel.h"

namespace eifmap {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kMostCameras = 64;  // each has threads and memory of its own

// Names of enumerators, as a user writes them.
struct InputNames {
  static constexpr std::array values{std::pair{"newest", InputMode::kNewest},
                                     std::pair{"lossless", InputMode::kLossless}};
};
struct ExtractorNames {
  static constexpr auto values = kExtractorNames;
};
struct ModelNames {
  static constexpr std::array values{std::pair{"pinhole", CameraModel::kPinhole},
                                     std::pair{"radial_tangential", CameraModel::kRadialTangential},
                                     std::pair{"fisheye", CameraModel::kFisheye}};
};

struct PoseStartNames {
  static constexpr std::array values{
      std::pair{"scale_fit", PoseStart::kScaleFit}, std::pair{"same_speed", PoseStart::kSameSpeed},
      std::pair{"triangulation", PoseStart::kTriangulation}, std::pair{"pnp", PoseStart::kPnp}};
};
struct MapSignNames {
  static constexpr std::array values{
      std::pair{"minus", MapSignChoice::kMinus}, std::pair{"plus", MapSignChoice::kPlus},
      std::pair{"both", MapSignChoice::kBoth}, std::pair{"merit", MapSignChoice::kMerit}};
};
struct CovarianceNames {
  static constexpr std::array values{std::pair{"linear", RelativePoseCovariance::kLinear},
                                     std::pair{"unscented", RelativePoseCovariance::kUnscented}};
};
struct ScaleFitNames {
  static constexpr std::array values{std::pair{"vote", ScaleFitMethod::kVote},
                                     std::pair{"plain", ScaleFitMethod::kPlain}};
};
struct RelinearizeNames {
  static constexpr std::array values{std::pair{"once", Relinearize::kOnce},
                                     std::pair{"threshold", Relinearize::kThreshold},
                                     std::pair{"always", Relinearize::kAlways}};
};

template <class Field>
struct NamesOf;
template <>
struct NamesOf<InputMode> : InputNames {};
template <>
struct NamesOf<ExtractorKind> : ExtractorNames {};
template <>
struct NamesOf<CameraModel> : ModelNames {};
template <>
struct NamesOf<RelativePoseCovariance> : CovarianceNames {};
template <>
struct NamesOf<ScaleFitMethod> : ScaleFitNames {};
template <>
struct NamesOf<Relinearize> : RelinearizeNames {};
template <>
struct NamesOf<PoseStart> : PoseStartNames {};
template <>
struct NamesOf<MapSignChoice> : MapSignNames {};

// Reads one JSON object into a struct. The first thing wrong is kept, by its full name.
class Reader {
 public:
  Reader(const Json& json, std::string path, std::string& problem)
      : json_(json), path_(std::move(path)), problem_(problem) {
    if (!json.is_object()) fail(path_, "an object");
  }

  template <class Field>
  void operator()(const char* name, Field& field) {
    names_.push_back(name);
    if (!problem_.empty() || !json_.contains(name)) return;
    read(json_[name], full_name(name), field);
  }

  void refuse_unknown() {
    if (!problem_.empty()) return;
    for (const auto& [key, value] : json_.items())
      if (std::find(names_.begin(), names_.end(), key) == names_.end()) {
        problem_ = full_name(key) + ": unknown" + did_you_mean(key, names_) + "; known are";
        for (const std::string& name : names_) problem_ += ' ' + name;
        return;
      }
  }

 private:
  std::string full_name(const std::string& name) const {
    return path_.empty() ? name : path_ + '.' + name;
  }

  void fail(const std::string& name, const std::string& wanted) {
    if (problem_.empty())
      problem_ = (name.empty() ? "the configuration" : name) + ": must be " + wanted;
  }

  void read(const Json& json, const std::string& name, bool& field) {
    if (!json.is_boolean()) return fail(name, "true or false, is " + json.dump());
    field = json.get<bool>();
  }

  void read(const Json& json, const std::string& name, int& field) {
    constexpr std::int64_t kMax = std::numeric_limits<int>::max();
    if (!json.is_number_integer() ||
        (json.is_number_unsigned() && json.get<std::uint64_t>() > kMax))
      return fail(name, "a whole number, is " + json.dump());
    const auto value = json.get<std::int64_t>();
    if (value < -kMax || value > kMax) return fail(name, "a smaller number, is " + json.dump());
    field = static_cast<int>(value);
  }

  void read(const Json& json, const std::string& name, double& field) {
    if (!json.is_number()) return fail(name, "a number, is " + json.dump());
    field = json.get<double>();
  }

  void read(const Json& json, const std::string& name, std::string& field) {
    if (!json.is_string()) return fail(name, "a text in quotes, is " + json.dump());
    field = json.get<std::string>();
  }

  void read(const Json& json, const std::string& name, std::array<double, 5>& field) {
    const auto is_number = [](const Json& entry) { return entry.is_number(); };
    if (!json.is_array() || json.size() > field.size() ||
        !std::all_of(json.begin(), json.end(), is_number))
      return fail(name, "a list of at most 5 numbers, is " + json.dump());
    field = {};
    std::transform(json.begin(), json.end(), field.begin(),
                   [](const Json& entry) { return entry.get<double>(); });
  }

  void read(const Json& json, const std::string& name, std::optional<Camera>& field) {
    field.reset();
    if (json.is_null()) return;
    read(json, name, field.emplace());
  }

  template <class Enum>
  requires std::is_enum_v<Enum>
  void read(const Json& json, const std::string& name, Enum& field) {
    std::string wanted = "one of";
    for (const auto& [text, value] : NamesOf<Enum>::values) {
      wanted += std::string(" \"") + text + '"';
      if (json != text) continue;
      field = value;
      return;
    }
    fail(name, wanted + ", is " + json.dump());
  }

  template <class Section>
  requires(std::is_class_v<Section>) void read(const Json& json, const std::string& name,
                                               Section& section) {
    Reader reader(json, name, problem_);
    if (!problem_.empty()) return;
    visit_fields(section, reader);
    reader.refuse_unknown();
  }

  const Json& json_;
  std::string path_;
  std::string& problem_;
  std::vector<std::string> names_;
};

class Writer {
 public:
  template <class Field>
  void operator()(const char* name, const Field& field) {
    if constexpr (std::is_enum_v<Field>) {
      for (const auto& [text, value] : NamesOf<Field>::values)
        if (value == field) json_[name] = text;
    } else if constexpr (std::is_same_v<Field, std::optional<Camera>>) {
      json_[name] = field ? section(*field) : Json();
    } else if constexpr (requires(Writer & w) { visit_fields(field, w); }) {
      json_[name] = section(field);
    } else {
      json_[name] = field;
    }
  }

  Json take() { return std::move(json_); }

  template <class Section>
  static Json section(const Section& section) {
    Writer writer;
    visit_fields(section, writer);
    return writer.take();
  }

 private:
  Json json_ = Json::object();
};

}  // namespace

std::string ServerConfig::problem() const {
  if (!camera.empty() && !valid_camera_name(camera))
    return "camera: must be empty or 1 to 24 of A-Z a-z 0-9 _ -, is \"" + camera + '"';
  if (max_cameras < 1 || max_cameras > kMostCameras)
    return "max_cameras: must be 1 to " + std::to_string(kMostCameras);
  if (camera == kNoCamera) return "camera: \"server\" is the server's own name, in its channels";
  if (!image_channel.empty() && camera.empty())
    return "image_channel: needs the name of its camera in \"camera\"";
  if (gray16_bits < 8 || gray16_bits > 16) return "gray16_bits: must be 8 to 16";
  if (hfov_deg != 0 && !(hfov_deg >= kMinHfovDeg && hfov_deg <= kMaxHfovDeg))
    return "hfov_deg: must be 10 to 150, or 0 for no guess";
  if (handover_frames < -1) return "handover_frames: must be -1, 0 or a number of frames";
  if (max_queued_mib < 1) return "max_queued_mib: must be at least 1";
  if (max_part_bytes != 0 && max_part_bytes < static_cast<int>(kMinPartBytes))
    return "max_part_bytes: must be at least " + std::to_string(kMinPartBytes) +
           ", or 0 for what suits the network";
  if (map_bytes_per_s < 1000) return "map_bytes_per_s: must be at least 1000";
  if (!(status_period_s >= 0.01 && status_period_s <= 60))
    return "status_period_s: must be 0.01 to 60";
  if (calibration && !calibration->problem().empty())
    return "calibration: " + calibration->problem();
  if (std::string found = form_problem(metrics_at()); !found.empty()) return found;
  if (const std::string found = features.problem(); !found.empty()) return "features." + found;
  if (const std::string found = mapper.problem(); !found.empty()) return "mapper." + found;
  return "";
}

ListenAt ServerConfig::metrics_at() const {
  return {metrics_address, metrics_port, "metrics_address", "metrics_port"};
}

std::size_t ServerConfig::part_bytes() const {
  return static_cast<std::size_t>(max_part_bytes > 0 ? max_part_bytes
                                                     : link_of(lcm_url).message_bytes);
}

ParsedConfig parse_config(const std::string& json_text, const ServerConfig& base) {
  ParsedConfig parsed;
  parsed.config = base;
  Json json;
  try {
    json = Json::parse(json_text, nullptr, true, /*ignore_comments=*/true);
  } catch (const Json::parse_error& error) {
    const auto end =
        json_text.begin() + static_cast<std::ptrdiff_t>(std::min(error.byte, json_text.size()));
    parsed.problem = "line " + std::to_string(1 + std::count(json_text.begin(), end, '\n')) +
                     " is not JSON; look for a missing quote, comma or bracket";
    return parsed;
  } catch (const Json::out_of_range&) {
    parsed.problem = "a number in it is too large for any setting";
    return parsed;
  }
  Reader reader(json, "", parsed.problem);
  if (!parsed.problem.empty()) return parsed;
  visit_fields(parsed.config, reader);
  reader.refuse_unknown();
  if (parsed.problem.empty()) parsed.problem = parsed.config.problem();
  return parsed;
}

std::string config_text(const ServerConfig& config) {
  return Writer::section(config).dump(2);
}

Handover ServerConfig::recorded_handover() const {
  if (handover_frames < 1) return {};
  return {Handover::When::kAfterFrames, handover_frames, {}};
}

Handover ServerConfig::live_handover() const {
  if (handover_frames < 0 && input == InputMode::kNewest) return {Handover::When::kWhenDone, 0, {}};
  return recorded_handover();
}

}  // namespace eifmap
