// Lines on stderr: refusals, notes and warnings, and the progress of long work, which is a bar with rate and
// time left on a terminal, plain lines otherwise, and nothing when quiet.
#pragma once

#include <chrono>
#include <string>
#include <vector>

namespace stratus {

/// Writes the line "stratus: MESSAGE", made fit for a terminal as shown() does, at most `max_message` bytes.
void say(std::string message);

class Progress {
  public:
    explicit Progress(bool quiet);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    /// Share done [0, 1] of a stage; a new stage, or less done than before, starts its own clock.
    void show(double done, const std::string& stage);

    void operator()(double done, const std::string& stage) { show(done, stage); }

    /// A line of its own, clear of the bar.
    void note(const std::string& line);
    /// Notes that reading a file gave.
    void notes(const std::vector<std::string>& notes) {
        for (const std::string& each : notes) note("note: " + each);
    }

  private:
    using Clock = std::chrono::steady_clock;

    void clear();

    bool quiet_;
    bool terminal_;
    bool drawn_ = false;
    std::string stage_;
    double done_ = 0;
    Clock::time_point started_, shown_;
};

}  // namespace stratus
