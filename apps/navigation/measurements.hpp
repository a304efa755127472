// Measurements on their way to the filter's horizon.
#pragma once

#include <array>
#include <cstdint>

#include "motion.hpp"

namespace stator::apps::navigation {

struct GnssMeasurement {
    uint64_t time_us = 0;
    Vector velocity_N = Vector::Zero();
    Vector position_N = Vector::Zero();  // down: 0
    double height = 0.0;                 // m, above mean sea level
    float velocity_variance = 0.0F;
    float position_variance = 0.0F;
    float height_variance = 0.0F;
    bool has_velocity = false;
    bool has_height = false;
};

struct BaroMeasurement {
    uint64_t time_us = 0;
    float height = 0.0F;  // m, in the standard atmosphere
};

struct MagMeasurement {
    uint64_t time_us = 0;
    Vector field_B = Vector::Zero();
};

// Measurements of one kind that wait until the filter's horizon reaches their time. First in, first
// out.
template <class Measurement, unsigned kCapacity>
class DelayedMeasurements {
  public:
    bool empty() const { return count_ == 0; }
    const Measurement& front() const { return items_[first_]; }
    void pop() {
        first_ = (first_ + 1) % kCapacity;
        --count_;
    }
    // False if there is no room, or it is not newer than the one before.
    [[nodiscard]] bool push(const Measurement& item) {
        if (count_ == kCapacity || item.time_us <= newest_us_) return false;
        items_[(first_ + count_) % kCapacity] = item;
        newest_us_ = item.time_us;
        ++count_;
        return true;
    }
    uint64_t newest_us() const { return newest_us_; }

  private:
    std::array<Measurement, kCapacity> items_{};
    uint64_t newest_us_ = 0;
    unsigned first_ = 0;
    unsigned count_ = 0;
};

// Whether a kind of measurement is believed.
class Aid {
  public:
    bool started() const { return started_; }
    uint64_t last_us() const { return last_us_; }
    bool recent(uint64_t now_us, float seconds) const {
        // A newer measurement of another kind may have come before.
        const uint64_t age_us = now_us > last_us_ ? now_us - last_us_ : 0;
        return started_ && static_cast<float>(age_us) * 1e-6F <= seconds;
    }
    // Notes how a measurement went. True if it should be believed all the same: it is the first,
    // or all were left out for `timeout` seconds.
    [[nodiscard]] bool note(bool fused, uint64_t time_us, float timeout) {
        if (fused) {
            accept(time_us);
            return false;
        }
        if (!refusing_) refused_us_ = time_us;
        refusing_ = true;
        return static_cast<float>(time_us - refused_us_) * 1e-6F > timeout;
    }
    void accept(uint64_t time_us) {
        started_ = true;
        refusing_ = false;
        last_us_ = time_us;
    }

  private:
    uint64_t last_us_ = 0;
    uint64_t refused_us_ = 0;
    bool started_ = false;
    bool refusing_ = false;
};

}  // namespace stator::apps::navigation
