// What the tests of the layouts have in common.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "sequence/image_folder.h"
#include "sequence/recorded_sequence.h"

namespace eifmap::test {

class LayoutTest : public testing::Test {
 protected:
  RecordedSequence::Opened open(const SequenceOptions& options = {}) const {
    return RecordedSequence::open(root(), options);
  }
  virtual std::filesystem::path root() const { return folder_.path(); }

  // One sentence that has all of these in it.
  void expect_problem(std::initializer_list<const char*> wanted,
                      const SequenceOptions& options = {}) const {
    const std::string problem = open(options).problem;
    for (const char* text : wanted)
      EXPECT_NE(problem.find(text), std::string::npos) << "got: " << problem;
    EXPECT_EQ(problem.find('\n'), std::string::npos) << problem;
  }

  void expect_grays(const RecordedSequence& sequence, const std::vector<int>& grays) const {
    ASSERT_EQ(sequence.size(), static_cast<int>(grays.size()));
    for (int i = 0; i < sequence.size(); ++i) {
      const GrayImage image = sequence.load_gray(i);
      ASSERT_EQ(image.problem, "");
      EXPECT_EQ(image.image.at<std::uint8_t>(5, 5), grays[static_cast<std::size_t>(i)]);
    }
  }

  static SequenceOptions hfov(double degrees) {
    SequenceOptions options;
    options.hfov_deg = degrees;
    return options;
  }

  ImageFolder folder_;
};

}  // namespace eifmap::test
