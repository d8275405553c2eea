// SIGINT and SIGTERM as something to ask for.
#pragma once

#include <pthread.h>

#include <csignal>
#include <ctime>

namespace eifmap {

// Blocks both signals in this thread and those it makes from now on: construct it first in main().
class StopSignals {
 public:
  StopSignals() {
    sigemptyset(&set_);
    sigaddset(&set_, SIGINT);
    sigaddset(&set_, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &set_, nullptr);
  }

  // Whether one has come since the start. From one thread.
  bool arrived() {
    const timespec at_once{};
    if (!arrived_ && sigtimedwait(&set_, nullptr, &at_once) > 0) arrived_ = true;
    return arrived_;
  }

 private:
  sigset_t set_;
  bool arrived_ = false;
};

}  // namespace eifmap
