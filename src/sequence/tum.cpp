#include "sequence/tum.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <optional>

#include "sequence/number_text.h"

namespace eifmap {
namespace {

using Row = std::array<double, 8>;

// The first word that is no number, if there is one.
std::optional<std::string> parse_row(const std::vector<std::string>& words, Row& row) {
  for (std::size_t i = 0; i < row.size(); ++i) {
    const auto number = parse_number(words[i]);
    if (!number) return words[i];
    row[i] = *number;
  }
  return std::nullopt;
}

TumPose pose_from_row(const Row& row) {
  TumPose pose{row[0], {{row[7], row[4], row[5], row[6]}, {row[1], row[2], row[3]}}};
  // What is already unit to rounding stays bit for bit, so that writing gives the same text again.
  const double norm = pose.world_from_camera.rotation.norm();
  if (std::abs(norm - 1) > 1e-12) pose.world_from_camera.rotation.coeffs() /= norm;
  return pose;
}

}  // namespace

TumTrajectory read_tum(const std::filesystem::path& file) {
  std::ifstream in(file);
  if (!in) return {{}, file.string() + ": cannot be read"};
  std::vector<Row> rows;
  std::string text;
  for (int line = 1; std::getline(in, text); ++line) {
    const auto words = split_words(text);
    Row row{};
    if (words.size() < row.size()) continue;
    const std::string where = file.string() + " line " + std::to_string(line) + ": ";
    if (const auto bad = parse_row(words, row))
      return {{}, where + "'" + *bad + "' is no number; wanted time tx ty tz qx qy qz qw"};
    if (!std::all_of(row.begin(), row.end(), [](double x) { return std::isfinite(x); })) continue;
    if (std::hypot(std::hypot(row[4], row[5]), std::hypot(row[6], row[7])) < 1e-6)
      return {{}, where + "the quaternion is zero"};
    rows.push_back(row);
  }
  std::sort(rows.begin(), rows.end());
  TumTrajectory trajectory;
  trajectory.poses.reserve(rows.size());
  for (const Row& row : rows) trajectory.poses.push_back(pose_from_row(row));
  return trajectory;
}

std::string tum_line(const TimedPose& pose) {
  constexpr std::int64_t kSecond = 1000000;
  const bool negative = pose.time_us < 0;
  const std::uint64_t time_us = negative ? 0 - static_cast<std::uint64_t>(pose.time_us)
                                         : static_cast<std::uint64_t>(pose.time_us);
  char time[48];
  std::snprintf(time, sizeof(time), "%s%llu.%06llu000", negative ? "-" : "",
                static_cast<unsigned long long>(time_us / kSecond),
                static_cast<unsigned long long>(time_us % kSecond));
  const auto& [q, t] = pose.world_from_camera;
  std::string line = time;
  for (double value : {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()})
    line += ' ' + exact_text(value);
  return line;
}

std::string write_tum(const std::filesystem::path& file, std::span<const TimedPose> poses) {
  std::ofstream out(file);
  for (const TimedPose& pose : poses) out << tum_line(pose) << '\n';
  out.close();
  return out ? "" : file.string() + ": cannot be written";
}

}  // namespace eifmap
