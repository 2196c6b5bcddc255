// Ctrl-C leaves no partial files: signals are blocked while a file is written.
#pragma once

#include <csignal>

namespace stratus {

/// Blocks SIGINT, SIGTERM and SIGHUP during its scope, which must be short; one received meanwhile
/// ends the program at the end of the scope.
///
/// Threads  constructed while no other thread runs; threads started in its scope inherit it.
class SignalsHeld {
  public:
    SignalsHeld() {
        sigset_t blocked;
        sigemptyset(&blocked);
        for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&blocked, signal);
        pthread_sigmask(SIG_BLOCK, &blocked, &before_);
    }
    ~SignalsHeld() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
    SignalsHeld(const SignalsHeld&) = delete;
    SignalsHeld& operator=(const SignalsHeld&) = delete;

  private:
    sigset_t before_;
};

}  // namespace stratus
