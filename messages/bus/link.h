// What a network takes without loss: how large a message, and how many bytes a second.
#pragma once

#include <string>

namespace eifmap {

struct Link {
  int message_bytes;  // a larger message is more than one datagram, and lost with any of them
  int bytes_per_s;    // 0: as fast as they come
};

inline constexpr Link kThisHost{32 * 1024, 0};
// A datagram of an Ethernet frame: 1,500 bytes less the headers of IP, UDP and LCM and a channel's
// name. The pace is one that the stock receive buffer keeps up with.
inline constexpr Link kOffHost{1400, 5'000'000};

// Of an LCM URL: kOffHost where its datagrams may leave the machine, udpm:// with a ttl above 0.
Link link_of(const std::string& lcm_url);

// Whether what is sent there reaches no other machine: memq://, file://, and multicast with a ttl
// of 0. Who answers what was sent there is on this machine, then; that what merely arrives is from
// it, LCM does not tell. False in doubt, and of tcpq://, whose server may serve anybody.
bool stays_on_this_machine(const std::string& lcm_url);

}  // namespace eifmap
