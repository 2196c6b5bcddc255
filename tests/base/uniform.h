// Numbers drawn evenly from an interval, the same in every run.
#pragma once

#include <random>

template <class Number = double>
class Uniform {
  public:
    explicit Uniform(unsigned seed, Number low = 0, Number high = 1)
        : engine_(seed), distribution_(low, high) {}

    Number operator()() { return distribution_(engine_); }

  private:
    std::mt19937 engine_;
    std::uniform_real_distribution<Number> distribution_;
};
