// Which of two instances of a node acts: the one on another machine, or the standby here.
//
// The standby acts from the start. The other one takes over while the vehicle is disarmed, once all
// its outputs are fresh. It loses its turn when one of them is too old, and does not get it back
// before the vehicle is disarmed: a machine that comes and goes must not take the controls in
// turns.
#pragma once

#include <array>
#include <cstdint>

namespace stator::machines {

template <unsigned kOutputs>
class Selector {
  public:
    using Ages = std::array<uint32_t, kOutputs>;  // us

    explicit Selector(const Ages& max_ages_us) : max_ages_us_(max_ages_us) {}

    void note_remote(unsigned output, uint64_t timestamp_us) {
        remote_us_[output] = timestamp_us;
        is_known_[output] = true;
    }
    // Each activation. `is_armed`: of a graph that does not say so, false.
    void decide(uint64_t now_us, bool is_armed) {
        is_fresh_ = true;
        for (unsigned i = 0; i < kOutputs; ++i) {
            const bool is_old = now_us > remote_us_[i] + max_ages_us_[i];
            is_fresh_ = is_fresh_ && is_known_[i] && !is_old;
        }
        if (is_remote_ && !is_fresh_) ++fallbacks_;
        is_remote_ = is_fresh_ && (is_remote_ || !is_armed);
    }
    bool is_remote() const { return is_remote_; }
    bool is_fresh() const { return is_fresh_; }
    uint32_t fallbacks() const { return fallbacks_; }

  private:
    Ages max_ages_us_;
    std::array<uint64_t, kOutputs> remote_us_{};
    std::array<bool, kOutputs> is_known_{};
    uint32_t fallbacks_ = 0;
    bool is_remote_ = false;
    bool is_fresh_ = false;
};

}  // namespace stator::machines
