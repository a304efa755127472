// Position estimation, between motion capture and position control.
#pragma once

#include "motion_filter.hpp"
#include "position_estimate_ports.hpp"

namespace stator::apps::position_estimate {

class PositionEstimate {
  public:
    // Takes whatever of its inputs is new, whichever came: moves on to the time of a newer attitude
    // and publishes there, and corrects with motion capture. Before the first sample of each it
    // says nothing. Without motion capture it goes on predicting, marked as not valid after a
    // while; without attitude or accelerometer it stands still and says nothing. Samples that are
    // not finite, or older than what it has, are left out.
    void step(PositionEstimatePorts& ports);

  private:
    using Vector = math::Vector3<float>;

    enum class State {
        kLost,       // no position
        kAcquiring,  // a position, but no velocity yet
        kTracking,
    };

    void gather(PositionEstimatePorts& ports);
    bool predict(const PositionEstimatePorts& ports);
    void measure(const VehicleOdometry& seen, const PositionEstimateParams& params);
    void begin_acquisition(const Vector& position, uint64_t time_us);
    void end_acquisition(const Vector& position, uint64_t time_us);
    VehicleLocalPosition estimate(const PositionEstimateParams& params) const;
    // Seconds by which the estimate is newer than `time_us`.
    float age_of(uint64_t time_us) const;

    MotionFilter filter_;
    State state_ = State::kLost;
    uint64_t time_us_ = 0;      // of the estimate; 0: none yet
    uint64_t measured_us_ = 0;  // time of the last measurement that was believed
    uint64_t acquired_us_ = 0;  // of the one that acquisition began with
    Vector acquired_ = Vector::Zero();
    // Since the last prediction: rotors shake the accelerometer faster than the attitude comes, and
    // one sample of several would turn that into a slow error.
    Vector forces_B_ = Vector::Zero();
    float force_count_ = 0.0F;
    float heading_ = 0.0F;
};

}  // namespace stator::apps::position_estimate
