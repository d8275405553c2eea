// The LCM network that server and client use unless told otherwise: loopback only (ttl 0), with a
// receive buffer that holds large images where the kernel grants it.
#pragma once

namespace eifmap {

inline constexpr const char* kDefaultLcmUrl =
    "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152";

}  // namespace eifmap
