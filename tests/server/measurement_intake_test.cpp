#include "server/measurement_intake.h"

#include <gtest/gtest.h>

namespace eifmap {
namespace {

std::vector<std::uint8_t> wire(std::int64_t publisher, std::int64_t seq,
                               const std::string& camera = "a") {
  AbsoluteMeasurement m;
  m.id = {publisher, seq};
  m.time_us = 1000 + seq;
  return encode(to_message(NamedMeasurement{camera, m}));
}

std::vector<std::int64_t> seqs(const std::vector<AbsoluteMeasurement>& measurements) {
  std::vector<std::int64_t> seqs;
  for (const AbsoluteMeasurement& m : measurements) seqs.push_back(m.id.seq);
  return seqs;
}

using Seqs = std::vector<std::int64_t>;

TEST(MeasurementIntake, GivesEachOnceInOrder) {
  MeasurementIntake intake(10);
  for (const int seq : {0, 1, 2}) EXPECT_EQ(intake.take("a", wire(5, seq)).reason, Reason::kNone);
  EXPECT_EQ(seqs(intake.give("a")), (Seqs{0, 1, 2}));
  EXPECT_TRUE(intake.give("a").empty());
  EXPECT_EQ(intake.take("a", wire(5, 3)).reason, Reason::kNone);
  EXPECT_EQ(seqs(intake.give("a")), Seqs{3});
  EXPECT_EQ(intake.counts().arrived, 4);
  EXPECT_EQ(intake.counts().missing, 0);
}

TEST(MeasurementIntake, RefusesWhatHasCome) {
  MeasurementIntake intake(10);
  // Two at a time, the numbers of one out of order and with a gap.
  for (const int seq : {0, 2, 1, 5}) {
    EXPECT_EQ(intake.take("a", wire(5, seq)).reason, Reason::kNone) << seq;
    EXPECT_EQ(intake.take("a", wire(6, seq)).reason, Reason::kNone) << seq;
    EXPECT_EQ(intake.take("a", wire(5, seq)).reason, Reason::kMeasurementRepeated) << seq;
  }
  EXPECT_EQ(intake.take("a", wire(5, 0)).reason, Reason::kMeasurementRepeated);
  EXPECT_EQ(intake.give("a").size(), 8u);
  const auto counts = intake.counts();
  EXPECT_EQ(counts.arrived, 13);
  EXPECT_EQ(counts.missing, 4) << "3 and 4 of each";
  EXPECT_EQ(counts.refused.refusals.at(Reason::kMeasurementRepeated), 5);
  EXPECT_EQ(counts.refused.kinds.at(MeasurementKind::kPosition).refused, 5);
}

TEST(MeasurementIntake, IsBounded) {
  MeasurementIntake intake(2);
  for (const int seq : {0, 1}) EXPECT_EQ(intake.take("a", wire(5, seq)).reason, Reason::kNone);
  EXPECT_EQ(intake.take("a", wire(5, 2)).reason, Reason::kTooManyMeasurements);
  EXPECT_EQ(seqs(intake.give("a")), (Seqs{0, 1}));
  for (int publisher = 1; publisher <= 40; ++publisher)
    for (const int seq : {0, 2}) intake.take("a", wire(publisher, seq));
  EXPECT_EQ(intake.counts().missing, 39) << "of forgotten ones too; not of 5's, whose 1 had come";
}

TEST(MeasurementIntake, OnlyOfTheCamera) {
  MeasurementIntake intake(10);
  EXPECT_EQ(intake.take("b", wire(5, 0, "b")).reason, Reason::kNone);
  EXPECT_EQ(intake.take("a", wire(6, 0)).reason, Reason::kNone);
  const auto taken = intake.take("a", wire(7, 0, "b"));
  EXPECT_EQ(taken.reason, Reason::kMalformedMessage);
  EXPECT_NE(taken.detail.find("camera b on a channel of camera a"), std::string::npos);
  EXPECT_EQ(intake.give("a").size(), 1u);
  EXPECT_TRUE(intake.give("b").empty());
}

TEST(MeasurementIntake, CountsWhatIsBad) {
  MeasurementIntake intake(10);
  auto bytes = wire(5, 0);
  bytes.pop_back();
  EXPECT_EQ(intake.take("a", bytes).reason, Reason::kMalformedMessage);
  EXPECT_EQ(intake.counts().refused.refusals.at(Reason::kMalformedMessage), 1);
  EXPECT_EQ(intake.take("a", wire(5, 0)).reason, Reason::kNone) << "it never came";
}

}  // namespace
}  // namespace eifmap
