#include "bus/link.h"

#include <gtest/gtest.h>

#include "bus/default_url.h"

namespace eifmap {
namespace {

TEST(Link, DatagramsThatMayLeaveTheHostAreSmallAndPaced) {
  for (const char* url :
       {"udpm://239.255.76.67:7667?ttl=1", "udpm://?recv_buf_size=9&ttl=3",
        "mpudpm://239.255.76.67:7667?ttl=1", "udpm://?ttl=12&transmit_only=true"}) {
    EXPECT_EQ(link_of(url).message_bytes, 1400) << url;
    EXPECT_GT(link_of(url).bytes_per_s, 0) << url;
  }
}

TEST(Link, OnThisHostTheyAreLarge) {
  for (const char* url :
       {kDefaultLcmUrl, "udpm://239.255.76.67:7667", "udpm://?ttl=0",
        "udpm://?ttl=", "udpm://?xttl=1", "memq://", "tcpq://10.0.0.1:7700", ""}) {
    EXPECT_EQ(link_of(url).message_bytes, 32 * 1024) << url;
    EXPECT_EQ(link_of(url).bytes_per_s, 0) << url;
  }
}

}  // namespace
}  // namespace eifmap
