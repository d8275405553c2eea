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

TEST(Link, StaysOnThisMachineWhereEveryTtlIsNought) {
  for (const char* url : {kDefaultLcmUrl, "udpm://239.255.76.67:7667", "udpm://?ttl=0", "memq://",
                          "mpudpm://239.255.76.67:7667?ttl=0", "file:///tmp/log?mode=r"})
    EXPECT_TRUE(stays_on_this_machine(url)) << url;
  for (const char* url :
       {"udpm://239.255.76.67:7667?ttl=1", "udpm://?ttl=0&ttl=1", "udpm://?ttl=1&ttl=0",
        "udpm://?ttl=0x1", "udpm://?ttl=01", "udpm://?ttl=", "udpm://?ttl=-1", "udpm://?ttl = 1",
        "mpudpm://239.255.76.67:7667?ttl=1", "tcpq://127.0.0.1:7700", "tcpq://10.0.0.1:7700", ""})
    EXPECT_FALSE(stays_on_this_machine(url)) << url;
}

}  // namespace
}  // namespace eifmap
