// Numbers drawn evenly from an interval, the same in every run.
#pragma once

#include <random>
#include <type_traits>

template <class Number = double>
class Uniform {
  public:
    explicit Uniform(unsigned seed, std::type_identity_t<Number> low = 0,
                     std::type_identity_t<Number> high = 1)
        : engine_(seed), distribution_(low, high) {}

    Number operator()() { return distribution_(engine_); }

  private:
    std::mt19937 engine_;
    std::uniform_real_distribution<Number> distribution_;
};
