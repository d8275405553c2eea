#include "wire/channel.h"

#include <algorithm>
#include <array>
#include <stdexcept>

namespace eifmap {
namespace {

constexpr std::string_view kPrefix = "eifmap.";
constexpr std::array<std::string_view, 13> kKinds{
    "image",    "features",    "calibration",      "pose",     "map",         "status",
    "decision", "measurement", "relative_request", "relative", "map_request", "command",
    "reply"};

bool valid_character(char c) {
  return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' ||
         c == '-';
}

}  // namespace

bool valid_camera_name(std::string_view camera) {
  return !camera.empty() && camera.size() <= kMaxCameraName &&
         std::all_of(camera.begin(), camera.end(), valid_character);
}

void require_camera_name(std::string_view camera) {
  if (!valid_camera_name(camera))
    throw std::invalid_argument("camera name '" + std::string(camera) +
                                "': must be 1 to 24 of A-Z a-z 0-9 _ -");
}

std::string camera_problem(std::string_view named, std::string_view channel) {
  if (named == channel) return "";
  return "it names camera " + std::string(named) + " on a channel of camera " +
         std::string(channel);
}

std::string_view to_string(ChannelKind kind) {
  return kKinds[static_cast<std::size_t>(kind)];
}

std::string channel_name(std::string_view camera, ChannelKind kind) {
  require_camera_name(camera);
  return std::string(kPrefix) + std::string(camera) + "." + std::string(to_string(kind));
}

std::optional<Channel> parse_channel(std::string_view name) {
  if (!name.starts_with(kPrefix)) return {};
  name.remove_prefix(kPrefix.size());
  const std::size_t dot = name.find('.');
  if (dot == std::string_view::npos || !valid_camera_name(name.substr(0, dot))) return {};
  const auto kind = std::find(kKinds.begin(), kKinds.end(), name.substr(dot + 1));
  if (kind == kKinds.end()) return {};
  return Channel{std::string(name.substr(0, dot)), static_cast<ChannelKind>(kind - kKinds.begin())};
}

std::string channel_pattern(std::string_view camera, ChannelKind kind) {
  if (!camera.empty()) require_camera_name(camera);
  const std::string name = camera.empty() ? "[A-Za-z0-9_-]+" : std::string(camera);
  return "eifmap\\." + name + "\\." + std::string(to_string(kind));
}

std::string literal_pattern(std::string_view name) {
  constexpr std::string_view kSpecial = "\\^$.|?*+()[]{}";
  std::string pattern;
  for (const char c : name) {
    if (kSpecial.find(c) != std::string_view::npos) pattern += '\\';
    pattern += c;
  }
  return pattern;
}

}  // namespace eifmap
