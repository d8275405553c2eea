#include "convert/feature_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "messages/samples.h"

namespace eifmap {
namespace {

FeaturePart decoded(const feature_frame_t& message) {
  const Decoded<FeaturePart> part = decode_feature_part(encode(message));
  EXPECT_TRUE(part.ok()) << part.detail;
  return part.value;
}

std::vector<feature_frame_t> parts_of_frame(std::int64_t seq, int features = 300) {
  FeatureFrame frame = samples::features(features);
  frame.seq = seq;
  frame.time_us += seq;
  return split_features(frame, 1400);
}

TEST(FeatureParts, EachFitsADatagramAndTheWholeIsTheFrame) {
  for (const int n : {0, 1, 13, 14, 50, 1000}) {
    const FeatureFrame frame = samples::features(n);
    const std::vector<feature_frame_t> parts = split_features(frame, 1400);
    FeatureAssembler assembler;
    std::vector<FeatureFrame> whole;
    for (const feature_frame_t& part : parts) {
      EXPECT_LE(part.getEncodedSize(), 1400);
      EXPECT_EQ(is_part_of_features(encode(part)), parts.size() > 1);
      EXPECT_TRUE(whole.empty());
      whole = assembler.add(decoded(part));
    }
    ASSERT_EQ(whole.size(), 1u) << n;
    EXPECT_EQ(encode(to_message(whole[0])), encode(to_message(frame))) << n;
  }
}

TEST(FeatureParts, AreNoWholeFrames) {
  const std::vector<feature_frame_t> parts = parts_of_frame(0);
  ASSERT_GT(parts.size(), 1u);
  EXPECT_EQ(decode_features(encode(parts[0])).reason, Reason::kMalformedMessage);
}

TEST(FeatureParts, NumbersThatCannotBeAreRefused) {
  feature_frame_t part = parts_of_frame(0)[0];
  for (const auto& [number, of] : {std::pair{-1, 5}, {5, 5}, {0, 0}, {0, -3}, {7, 30000}}) {
    part.part = static_cast<std::int16_t>(number);
    part.num_parts = static_cast<std::int16_t>(of);
    EXPECT_EQ(decode_feature_part(encode(part)).reason, Reason::kMalformedMessage);
  }
}

// A frame in parts is no larger than a whole one may be.
TEST(FeatureParts, TooManyFeaturesForOneOfManyPartsAreRefused) {
  feature_frame_t part = to_message(samples::features(300));
  part.num_parts = 80;
  EXPECT_EQ(decode_feature_part(encode(part)).reason, Reason::kMalformedMessage);
  part.num_parts = 60;
  EXPECT_TRUE(decode_feature_part(encode(part)).ok());
}

TEST(FeatureParts, ASecondRunUnderTheSameIdIsNotLate) {
  FeatureAssembler assembler;
  std::vector<FeatureFrame> whole;
  for (const std::int64_t hours : {0, 1})
    for (std::int64_t seq = 0; seq < 30; ++seq)
      for (feature_frame_t& part : parts_of_frame(seq)) {
        part.utime += 3'600'000'000 * hours;
        for (FeatureFrame& frame : assembler.add(decoded(part))) whole.push_back(std::move(frame));
      }
  EXPECT_EQ(whole.size(), 60u);
}

TEST(FeatureParts, OrderAndRepetitionDoNotMatterWithinAFrame) {
  std::vector<feature_frame_t> parts = parts_of_frame(3);
  const std::vector<std::uint8_t> frame = [&] {
    FeatureAssembler assembler;
    std::vector<FeatureFrame> whole;
    for (const auto& part : parts) whole = assembler.add(decoded(part));
    return encode(to_message(whole.at(0)));
  }();
  std::shuffle(parts.begin(), parts.end(), std::mt19937(1));
  FeatureAssembler assembler;
  std::vector<FeatureFrame> whole;
  for (const auto& part : parts)
    for (const int time : {0, 1})
      for (FeatureFrame& finished : assembler.add(decoded(part))) {
        EXPECT_EQ(time, 0);
        whole.push_back(std::move(finished));
      }
  ASSERT_EQ(whole.size(), 1u);
  EXPECT_EQ(encode(to_message(whole[0])), frame);
  EXPECT_EQ(assembler.counts().late_parts, static_cast<std::int64_t>(parts.size()));
}

TEST(FeatureParts, ALostPartCostsItsFeaturesAlone) {
  FeatureAssembler assembler;
  const std::vector<feature_frame_t> first = parts_of_frame(0), second = parts_of_frame(1);
  for (std::size_t p = 0; p < first.size(); ++p)
    if (p != 2) {
      EXPECT_TRUE(assembler.add(decoded(first[p])).empty());
    }
  const std::vector<FeatureFrame> given_up = assembler.add(decoded(second[0]));
  ASSERT_EQ(given_up.size(), 1u);
  EXPECT_EQ(given_up[0].seq, 0);
  EXPECT_EQ(given_up[0].keypoints.size(), 300 - static_cast<std::size_t>(first[2].n));
  EXPECT_TRUE(
      std::is_sorted(given_up[0].keypoints.begin(), given_up[0].keypoints.end(),
                     [](const Keypoint& a, const Keypoint& b) { return a.response > b.response; }));
  EXPECT_EQ(given_up[0].descriptors.size(), given_up[0].keypoints.size() * kDescriptorSize);
  EXPECT_TRUE(assembler.add(decoded(first[2])).empty()) << "too late";
  EXPECT_EQ(assembler.counts().incomplete, 1);
  EXPECT_EQ(assembler.counts().missing_parts, 1);
  EXPECT_EQ(assembler.counts().late_parts, 1);
}

TEST(FeatureParts, APublisherThatBeginsAgainIsNotLate) {
  FeatureAssembler assembler;
  for (const auto& part : parts_of_frame(5000)) assembler.add(decoded(part));
  std::vector<FeatureFrame> whole;
  for (const auto& part : parts_of_frame(0)) whole = assembler.add(decoded(part));
  EXPECT_EQ(whole.size(), 1u);
  for (feature_frame_t part : parts_of_frame(0)) {
    part.publisher = 77;
    whole = assembler.add(decoded(part));
  }
  EXPECT_EQ(whole.size(), 1u);
}

// Any loss, order and repetition: frames come out once each, in order, with the features of the
// parts that came.
TEST(FeatureParts, NothingIsMadeUpOnABadLink) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    std::mt19937 random(seed);
    std::vector<feature_frame_t> sent;
    for (std::int64_t seq = 0; seq < 20; ++seq)
      for (const feature_frame_t& part : parts_of_frame(seq, 100)) {
        if (random() % 100 < 5) continue;
        sent.push_back(part);
        if (random() % 100 < 5) sent.push_back(part);
      }
    for (std::size_t i = 1; i < sent.size(); ++i)
      if (random() % 100 < 20) std::swap(sent[i - 1], sent[i]);
    FeatureAssembler assembler;
    std::int64_t last = -1;
    const auto check = [&last](const FeatureFrame& frame) {
      EXPECT_GT(frame.seq, last);
      last = frame.seq;
      EXPECT_LE(frame.keypoints.size(), 100u);
      EXPECT_EQ(frame.descriptors.size(), frame.keypoints.size() * kDescriptorSize);
    };
    for (const feature_frame_t& part : sent)
      for (const FeatureFrame& frame : assembler.add(decoded(part))) check(frame);
    if (const auto frame = assembler.give_up()) check(*frame);
    EXPECT_GE(assembler.counts().whole + assembler.counts().incomplete, 18);
  }
}

}  // namespace
}  // namespace eifmap
