#include "server/metrics_text.h"

#include <gtest/gtest.h>

#include <charconv>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "convert/feature_parts.h"
#include "server/server_network.h"
#include "support/feature_world.h"

namespace eifmap {
namespace {

// What a text in the format says: samples by name and labels as they are written. Everything that
// the format does not allow is a failure.
class Parsed {
 public:
  explicit Parsed(const std::string& text) {
    EXPECT_TRUE(text.ends_with('\n'));
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);)
      line.starts_with('#') ? take_comment(line) : take_sample(line);
  }

  double operator[](const std::string& sample) const {
    const auto found = samples_.find(sample);
    return found == samples_.end() ? std::nan("") : found->second;
  }
  double sum(const std::string& begin) const {
    double sum = 0;
    for (const auto& [sample, value] : samples_)
      if (sample.starts_with(begin)) sum += value;
    return sum;
  }
  std::size_t size() const { return samples_.size(); }

 private:
  static std::size_t name_end(const std::string& line, std::size_t at) {
    EXPECT_TRUE(std::isalpha(line[at]) || line[at] == '_') << line;
    while (at < line.size() && (std::isalnum(line[at]) || line[at] == '_')) ++at;
    return at;
  }

  // HELP, then TYPE, once a family.
  void take_comment(const std::string& line) {
    std::istringstream words(line);
    std::string hash, what, name, rest;
    words >> hash >> what >> name;
    std::getline(words, rest);
    if (what == "HELP") {
      EXPECT_TRUE(families_.insert(name).second) << name << " is there twice";
      EXPECT_GT(rest.size(), 2u) << line;
    } else {
      EXPECT_EQ(what, "TYPE") << line;
      EXPECT_EQ(name, family_) << "HELP comes first";
      EXPECT_TRUE(rest == " gauge" || rest == " counter") << line;
      EXPECT_EQ(rest == " counter", name.ends_with("_total")) << line;
    }
    family_ = name;
  }

  void take_sample(const std::string& line) {
    std::size_t at = name_end(line, 0);
    EXPECT_EQ(line.substr(0, at), family_) << "families are in one piece";
    if (line[at] == '{') at = labels_end(line, at);
    ASSERT_EQ(line[at], ' ') << line;
    const std::string number = line.substr(at + 1);
    double value = 0;
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), value);
    EXPECT_TRUE(error == std::errc() && end == number.data() + number.size()) << line;
    EXPECT_TRUE(samples_.emplace(line.substr(0, at), value).second) << line << " is there twice";
  }

  static std::size_t labels_end(const std::string& line, std::size_t at) {
    do {
      at = name_end(line, at + 1);
      EXPECT_EQ(line.substr(at, 2), "=\"") << line;
      for (at += 2; at < line.size() && line[at] != '"'; ++at)
        if (line[at] == '\\') {
          ++at;
          EXPECT_TRUE(line[at] == '\\' || line[at] == '"' || line[at] == 'n') << line;
        }
      ++at;
    } while (at < line.size() && line[at] == ',');
    EXPECT_EQ(line[at], '}') << line;
    return at + 1;
  }

  std::string family_;
  std::set<std::string> families_;
  std::map<std::string, double> samples_;
};

diagnostic_t diagnostic(const std::string& key, const std::string& value) {
  diagnostic_t entry;
  entry.key = key;
  entry.value = value;
  return entry;
}

status_t status_of(const std::string& camera) {
  status_t status{};
  status.camera = camera;
  status.version = "1.2";
  return status;
}

TEST(MetricsText, SaysEachCamerasFigures) {
  status_t own = status_of(""), front = status_of("front"), rear = status_of("rear");
  own.rss_bytes = 123456789;
  own.diagnostics.push_back(diagnostic("cameras.mapped", "2"));
  own.diagnostics.push_back(diagnostic("loops.closed", "0"));
  front.frames_received = 12345678901;
  front.latency_ms_p50 = 12.5;
  front.latency_ms_p99 = 250;
  front.map_seq = 77;
  front.sigma_log_scale = std::nan("");
  front.diagnostics.push_back(diagnostic("rejected.CORRUPT_IMAGE", "3"));
  front.diagnostics.push_back(diagnostic("nis.sight.ratio", "1.02"));
  front.diagnostics.push_back(diagnostic("publisher.clock_offset_us", "-2500"));
  rear.state = status_t::STATE_LOST;
  rear.diagnostics.push_back(diagnostic("measurements.position.used", "9"));
  rear.diagnostics.push_back(diagnostic("measurements.refused.MEASUREMENT_GATED", "4"));
  rear.diagnostics.push_back(diagnostic("something.new", "5"));
  rear.diagnostics.push_back(diagnostic("send_failures", "many"));
  const Parsed said(metrics_text({own, front, rear}));
  EXPECT_EQ(said["eifmap_info{version=\"1.2\"}"], 1);
  EXPECT_EQ(said["eifmap_resident_memory_bytes"], 123456789);
  EXPECT_EQ(said["eifmap_cameras"], 2);
  EXPECT_TRUE(std::isnan(said["eifmap_loops_closed_total"])) << "of cameras alone";
  EXPECT_EQ(said["eifmap_frames_received_total{camera=\"front\"}"], 12345678901);
  EXPECT_EQ(said["eifmap_frames_received_total{camera=\"rear\"}"], 0);
  EXPECT_NEAR(said["eifmap_latency_seconds{camera=\"front\",quantile=\"0.5\"}"], 0.0125, 1e-9);
  EXPECT_NEAR(said["eifmap_latency_seconds{camera=\"front\",quantile=\"0.99\"}"], 0.25, 1e-9);
  EXPECT_EQ(said["eifmap_map_seq{camera=\"front\"}"], 77);
  EXPECT_EQ(said["eifmap_frames_rejected_total{camera=\"front\",reason=\"CORRUPT_IMAGE\"}"], 3);
  EXPECT_EQ(said["eifmap_innovation_ratio{camera=\"front\",kind=\"sight\"}"], 1.02);
  EXPECT_NEAR(said["eifmap_publisher_clock_offset_seconds{camera=\"front\"}"], -0.0025, 1e-12);
  EXPECT_EQ(said["eifmap_state{camera=\"rear\"}"], 3);
  EXPECT_EQ(said["eifmap_measurements_used_total{camera=\"rear\",kind=\"position\"}"], 9);
  EXPECT_EQ(said["eifmap_measurements_refused_by_reason_total{camera=\"rear\",reason="
                 "\"MEASUREMENT_GATED\"}"],
            4);
  EXPECT_TRUE(std::isnan(said["eifmap_send_failures_total{camera=\"rear\"}"])) << "is no number";
}

TEST(MetricsText, LabelsAreEscaped) {
  status_t own = status_of("");
  own.version = "a\\b\"c\nd";
  const std::string text = metrics_text({own});
  EXPECT_NE(text.find("eifmap_info{version=\"a\\\\b\\\"c\\nd\"} 1\n"), std::string::npos) << text;
  const Parsed said(text);
  EXPECT_GT(said.size(), 3u);
}

// Of a server that has seen good and bad: no figure of its statuses is forgotten.
TEST(MetricsText, HasEveryFigureOfARunningServer) {
  const SyntheticStream stream;
  ServerConfig config = lossless();
  config.max_cameras = 1;
  Network network(config);
  network.publish({"cam0", ChannelKind::kFeatures}, std::vector<std::uint8_t>(100, 7));
  network.publish(synthetic_camera());
  network.publish(synthetic_camera(), "cam1");
  AbsoluteMeasurement position;
  position.id = {9, 1};
  position.time_us = stream.frame(3).time_us;
  position.covariance = Eigen::Matrix3d::Identity();
  network.publish(position);
  network.publish(position);
  for (int i = 0; i < 40; ++i) network.publish(stream.frame(i));
  for (const feature_frame_t& part : split_features(stream.frame(40), 1400))
    network.publish({"cam0", ChannelKind::kFeatures}, encode(part));
  network.publish({"cam0", ChannelKind::kFeatures}, std::vector<std::uint8_t>(100, 7));
  network.settle();
  network.server->stop();  // with a last status of each
  const std::vector<status_t> statuses = network.server->statuses();
  network.finish();
  ASSERT_EQ(statuses.size(), 2u);
  const status_t& last = statuses[1];
  const std::set<std::string> no_figures{"publisher.id"};
  for (const status_t& status : statuses)
    for (const diagnostic_t& entry : status.diagnostics)
      EXPECT_NE(is_metric(entry.key), no_figures.contains(entry.key)) << entry.key;
  const Parsed said(metrics_text(statuses));
  EXPECT_EQ(said["eifmap_frames_received_total{camera=\"cam0\"}"], 43);
  EXPECT_EQ(said["eifmap_frames_processed_total{camera=\"cam0\"}"], 41);
  EXPECT_EQ(said.sum("eifmap_frames_rejected_total{camera=\"cam0\""), 2);
  EXPECT_EQ(last.frames_rejected, 2);
  EXPECT_EQ(said["eifmap_keyframes{camera=\"cam0\"}"], last.num_keyframes);
  EXPECT_EQ(said["eifmap_split_frames_whole_total{camera=\"cam0\"}"], 1);
  EXPECT_EQ(said["eifmap_measurements_refused_by_reason_total{camera=\"cam0\",reason="
                 "\"MEASUREMENT_REPEATED\"}"],
            1);
  EXPECT_EQ(said["eifmap_cameras"], 1);
  EXPECT_EQ(said["eifmap_cameras_refused"], 1);
}

}  // namespace
}  // namespace eifmap
