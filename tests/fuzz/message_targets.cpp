// Every decoder of messages. What it takes must be the same after another way over the wire, and
// what it refuses have a reason in words.
#include <algorithm>

#include "convert/feature_parts.h"
#include "fuzz/target.h"
#include "messages/samples.h"
#include "published/map_follower.h"

namespace eifmap::fuzz {
namespace {

template <class Message>
const Message& to_message(const Message& message) {
  return message;
}

template <class Value>
Target message(const std::string& name, Decoded<Value> (*decode)(Bytes),
               std::function<std::vector<Wire>()> seeds) {
  const auto run = [decode](Bytes bytes) {
    const Decoded<Value> first = decode(bytes);
    require(first.ok() || !first.detail.empty(), "a refusal has words");
    if (!first.ok()) return false;
    const Wire once = encode(to_message(first.value));
    const Decoded<Value> second = decode(once);
    require(second.ok(), "what was taken is taken again");
    require(encode(to_message(second.value)) == once, "what was taken is the same again");
    return true;
  };
  return {name, run, std::move(seeds)};
}

// Decoded alone: it is not made of what was decoded.
template <class Value>
Target one_way(const std::string& name, Decoded<Value> (*decode)(Bytes),
               std::function<std::vector<Wire>()> seeds) {
  const auto run = [decode](Bytes bytes) {
    const Decoded<Value> decoded = decode(bytes);
    require(decoded.ok() || !decoded.detail.empty(), "a refusal has words");
    return decoded.ok();
  };
  return {name, run, std::move(seeds)};
}

std::vector<Wire> images() {
  std::vector<Wire> wires;
  for (const PixelFormat format : {PixelFormat::kGray, PixelFormat::kNv12, PixelFormat::kMjpeg}) {
    ImageMessage image = samples::image();
    image.format = format;
    if (format == PixelFormat::kMjpeg) image.row_stride = 0;
    wires.push_back(encode(to_message(image)));
  }
  return wires;
}

std::vector<Wire> parts_of_features() {
  std::vector<Wire> wires = {encode(to_message(samples::features(4)))};
  for (const feature_frame_t& part : split_features(samples::features(6), 600))
    wires.push_back(encode(part));
  return wires;
}

std::vector<Wire> measurements() {
  std::vector<Wire> wires;
  for (const NamedMeasurement& m : samples::measurements()) wires.push_back(encode(to_message(m)));
  return wires;
}

map_part_t map_part() {
  return to_message(samples::map_update(2, 5, -1), {42, "cam0"}, 7);
}

// What comes after as many adds nothing but time.
constexpr int kMostParts = 100;

// Frames whose parts come in any order, twice, or not: each byte says what comes next.
bool assemble(Bytes bytes) {
  ByteReader in(bytes);
  FeatureAssembler assembler;
  std::int64_t parts = 0, frames = 0;
  for (int i = 0; i < kMostParts && !in.empty(); ++i) {
    FeaturePart part;
    part.frame = samples::features(in.below(3), 1 + static_cast<unsigned>(in.below(2)));
    part.frame.publisher = in.below(2);
    part.frame.seq = in.below(4) - 1;
    part.frame.time_us = in.below(4);
    part.num_parts = 1 + in.below(4);
    part.part = in.below(part.num_parts);
    ++parts;
    frames += static_cast<std::int64_t>(assembler.add(std::move(part)).size());
    if (in.below(8) == 0) frames += assembler.give_up().has_value();
  }
  frames += assembler.give_up().has_value();
  require(!assembler.give_up(), "nothing is left");
  const auto& counts = assembler.counts();
  require(counts.whole + counts.incomplete == frames, "every frame is counted");
  require(frames + counts.late_parts <= parts, "no frame comes of nothing");
  return counts.whole > 0 && counts.incomplete > 0;
}

// Updates whose parts come in any order, contradict each other, or not at all.
bool follow(Bytes bytes) {
  ByteReader in(bytes);
  MapFollower follower(5);
  MapFollower::TimePoint now{};
  for (int i = 0; i < kMostParts && !in.empty(); ++i) {
    now += std::chrono::milliseconds(in.below(200));
    const int base = in.below(6) - 1;
    MapUpdate update = samples::map_update(1 + in.below(2), in.below(4), base, in.below(3));
    update.seq = base + 1 + in.below(3);
    update.map_id = 1 + in.below(2);
    if (in.below(4) == 3) update.removed_landmarks = {in.below(4)};
    map_part_t part = to_message(update, {40 + in.below(2), "cam0"}, 7);
    PublishedMap after = follower.map();
    after.apply(part);
    part.digest = in.below(4) == 3 ? 1 : after.digest();
    part.num_parts = 1 + in.below(3);
    part.part = in.below(part.num_parts);
    if (const auto decoded = decode_map_part(encode(part)); decoded.ok())
      follower.take(decoded.value, now);
    if (in.below(8) == 7)
      follower.hear("cam0", 40 + in.below(3), in.below(9), now, std::int64_t{in.below(3)});
    if (const auto request = follower.ask(now, 1))
      require(decode_map_request(encode(*request)).ok(), "a request is a good message");
    follower.take_changes();
  }
  return follower.counts().updates > 0;
}

// As the above read them. A frame in two parts, one of two of which one is missing, and one more.
std::vector<Wire> assembly() {
  const auto part = [](std::uint8_t seq, std::uint8_t part_number) {
    return Wire{1, 0, 0, seq, seq, 1, part_number, 1};
  };
  Wire wire;
  for (const Wire& next : {part(1, 0), part(1, 1), part(2, 0), part(3, 1), part(3, 0)})
    wire.insert(wire.end(), next.begin(), next.end());
  return {wire};
}

// A whole map, and two steps, the second one in two parts.
std::vector<Wire> followed() {
  return {{1, 0, 0, 2, 0, 1, 0, 0, 0, 0, 0, 0, 0,  //
           1, 2, 1, 3, 1, 0, 0, 0, 0, 0, 0, 0, 0,  //
           1, 3, 0, 1, 0, 0, 0, 3, 1, 0, 0, 1, 0,  //
           1, 3, 0, 1, 0, 0, 0, 3, 1, 0, 0, 1, 1}};
}

template <class Value>
std::function<std::vector<Wire>()> one(Value (*sample)()) {
  return [sample] { return std::vector<Wire>{encode(to_message(sample()))}; };
}

}  // namespace

std::vector<Target> message_targets() {
  using namespace samples;
  return {
      message("camera", &decode_camera, one(&camera)),
      message("image", &decode_image, &images),
      message("features", &decode_features,
              [] { return std::vector<Wire>{parts_of_features()[0]}; }),
      one_way("feature_part", &decode_feature_part, &parts_of_features),
      message("measurement", &decode_measurement, &fuzz::measurements),
      message("decision", &decode_decision, one(&published_decision)),
      message("pose", &decode_pose, one(&published_pose)),
      message("status", &decode_status, one(&samples::status)),
      message("relative_request", &decode_relative_request, one(&relative_request)),
      message("relative", &decode_relative, one(&relative_answer)),
      message("map_request", &decode_map_request, one(&samples::map_request)),
      message("map_part", &decode_map_part, one(&map_part)),
      one_way("said_by_pose", &said_by_pose, one(&published_pose)),
      one_way("said_by_status", &said_by_status, one(&samples::status)),
      {"feature_assembly", &assemble, &assembly},
      {"map_follower", &follow, &followed},
  };
}

}  // namespace eifmap::fuzz
