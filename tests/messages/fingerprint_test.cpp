#include <gtest/gtest.h>

#include <bot_core/image_t.hpp>

// Existing camera drivers publish this very type; a change of the schema would make them strangers.
TEST(Fingerprint, ImageIsBotCores) {
  EXPECT_EQ(static_cast<std::uint64_t>(bot_core::image_t::getHash()), 0x14739ffe13d5f5f0u);
}
