// Ctrl-C leaves no half file: signals that end the program wait while one is written.
#pragma once

#include <csignal>

namespace stratus {

/// Holds back SIGINT, SIGTERM and SIGHUP during its scope, which must be short; whichever came
/// meanwhile ends the program at its end.
///
/// Threads  to be made while no other thread runs; those started in its scope hold them back too.
class SignalsHeld {
  public:
    SignalsHeld() {
        sigset_t ending;
        sigemptyset(&ending);
        for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&ending, signal);
        pthread_sigmask(SIG_BLOCK, &ending, &before_);
    }
    ~SignalsHeld() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
    SignalsHeld(const SignalsHeld&) = delete;
    SignalsHeld& operator=(const SignalsHeld&) = delete;

  private:
    sigset_t before_;
};

}  // namespace stratus
