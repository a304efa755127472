// Navigation, between the sensors and everything that must know where the vehicle is.
//
//     IMU samples -> MotionWindow -> Filter at the horizon, `fusion_delay` ago -> moved to now
//     satellites, barometer, magnetometer -> wait until the horizon reaches their time -^
//
// The filter runs late, so that each measurement meets the state of the time it was made; what the
// IMU felt since then is one motion, with which the state is brought to now at each activation. An
// activation fuses at most one scalar and predicts at most one step, so that its cost is bounded
// whatever arrives at once.
#pragma once

#include "alignment.hpp"
#include "disagreement.hpp"
#include "doubt.hpp"
#include "filter.hpp"
#include "measurements.hpp"
#include "stator/geodesy.hpp"

namespace stator::apps::navigation {

class Navigation {
  public:
    // Says nothing until a few tenths of a second of IMU samples have shown where level is. Then
    // it always knows an attitude; heading, height and position as soon as their sensors speak,
    // and the `valid` flags say which. Samples that are not finite, or not newer than the one
    // before, are left out; after a gap in the IMU's samples it starts again.
    void step(NavigationPorts& ports);

  private:
    static constexpr float kRestTime = 1.0F;  // s: still for so long is at rest
    // The output predictor's correction: what its output still differs by from the estimate, so
    // that a correction of the filter does not make it jump.
    struct OutputCorrection {
        Vector turn_N = Vector::Zero();
        Vector velocity_N = Vector::Zero();
        Vector position_N = Vector::Zero();
    };

    // Inputs.
    // Nothing was measured later than now: such a clock is wrong.
    bool is_of_the_past(uint64_t time_us) const { return time_us <= now_us_ + kClock_us; }
    void read_gnss(const SensorGps& fix, const NavigationParams& params);
    void read_baro(const SensorBaro& sample, float wash);  // Pa, of the rotors
    void read_mag(const SensorMag& sample);
    bool read_imu(NavigationPorts& ports);
    void add_imu(uint64_t time_us, const Vector& rate_B, const NavigationParams& params);
    void start(const NavigationParams& params);
    void compare(const GnssMeasurement& fix);
    bool receiver_is_consistent() const;
    float contradicts_for(uint64_t time_us);
    bool barometer_drifts() const;
    void believe_vertical(const GnssMeasurement& fix, float velocity);
    void watch_rest(const Vector& rate_B, const Vector& force_B, float dt);

    // The filter: each returns whether it had something to do.
    void work(const NavigationParams& params);
    bool fuse_gnss(const NavigationParams& params);
    bool fuse_baro(const NavigationParams& params);
    bool fuse_mag(const NavigationParams& params);
    bool fuse_rest(const NavigationParams& params);
    bool predict(const NavigationParams& params, bool at_once);

    void fuse_velocity(unsigned axis, const GnssMeasurement& fix, const NavigationParams& params);
    void fuse_position(unsigned axis, const GnssMeasurement& fix, const NavigationParams& params);
    void fuse_height(const GnssMeasurement& fix, const NavigationParams& params);
    void align_heading(float error, float variance, const NavigationParams& params);
    // Seconds from a measurement to the horizon.
    float age(uint64_t time_us) const {
        return static_cast<float>(filter_.time_us() - time_us) * 1e-6F;
    }
    template <class Measurement, unsigned kCapacity>
    bool is_due(DelayedMeasurements<Measurement, kCapacity>& delayed);

    // Outputs.
    // Of the newest sample, s: by how much its time is off.
    float imu_age() const {
        const uint64_t age_us = now_us_ > imu_us_ ? now_us_ - imu_us_ : imu_us_ - now_us_;
        return static_cast<float>(age_us) * 1e-6F;
    }
    void smooth(const Kinematics& before, const Kinematics& after);
    Kinematics output() const;
    void publish(NavigationPorts& ports);
    float vertical_disagreement() const;
    void publish_lost(NavigationPorts& ports) const;
    VehicleLocalPosition local_position(const Kinematics& now,
                                        const NavigationParams& params) const;
    void publish_state(NavigationPorts& ports) const;

    Filter filter_;
    MotionWindow window_;
    Alignment alignment_;
    bool started_ = false;
    bool was_started_ = false;  // once

    DelayedMeasurements<GnssMeasurement, 8> gnss_;
    DelayedMeasurements<BaroMeasurement, 16> baro_;
    DelayedMeasurements<MagMeasurement, 16> mag_;
    uint32_t late_ = 0;

    static constexpr uint64_t kClock_us = 20'000;
    uint64_t now_us_ = 0;
    // The newest IMU sample.
    uint64_t imu_us_ = 0;
    uint64_t accel_us_ = 0;
    Vector rate_B_ = Vector::Zero();
    Vector force_B_ = Vector::Zero();
    Vector queued_force_B_ = Vector::Zero();
    float rest_s_ = 0.0F;  // for how long it has been still
    bool disarmed_ = false;
    bool flies_ = false;      // for certain
    bool has_flown_ = false;  // since it was armed: what has landed may only seem to
    float command_ = 0.0F;    // the motors' sum

    // What the fusion goes on with in the next activation.
    unsigned gnss_next_ = 0;
    unsigned rest_next_ = 0;
    uint64_t rest_due_us_ = 0;
    bool north_fused_ = false;
    bool measured_ = false;  // something was fused since the last activation

    Aid velocity_aid_;
    Aid position_aid_;
    Aid height_aid_;
    Aid heading_aid_;
    float baro_reference_ = 0.0F;  // m, what the barometer says at the origin
    bool has_baro_reference_ = false;
    BaroRate baro_rate_;
    Doubt doubt_;
    Disagreement disagreement_;
    // What the receiver's velocity differs by from how its positions change, low-passed.
    Vector inconsistency_N_ = Vector::Zero();
    Vector contradiction_N_ = Vector::Zero();  // the same, of which jumps are a small part
    Vector last_fix_N_ = Vector::Zero();
    Vector last_fix_velocity_N_ = Vector::Zero();
    double last_fix_height_ = 0.0;
    float drifts_for_s_ = 0.0F;
    float fix_interval_s_ = 0.0F;
    float vertical_refused_s_ = 0.0F;  // for how long satellites' vertical velocity was left out
    // Where the receiver went without a velocity that explains it.
    Eigen::Vector2f receiver_jump_N_ = Eigen::Vector2f::Zero();
    uint64_t last_fix_us_ = 0;
    static constexpr float kProven_s = 5.0F;
    float proven_s_ = 0.0F;  // of flight in which satellites agreed with the heading
    float proven_mag_offset_ = 0.0F;
    float nose_variance() const;   // of the heading, as the output says it
    uint64_t contradicts_us_ = 0;  // since when; and when last
    uint64_t contradicted_us_ = 0;
    bool gnss_height_fits_ = false;
    bool baro_has_failed_ = false;
    Frozen frozen_gyro_;
    std::array<Frozen, 3> clipped_gyro_;
    // When it last turned faster than the gyro can measure, tumbled, or contradicted satellites.
    uint64_t astray_us_ = 0;
    Spike gyro_spike_{1e3F};     // rad/s^2
    Spike accel_spike_{1.2e4F};  // m/s^3
    Frozen frozen_gnss_;
    Frozen frozen_baro_;

    math::LocalFrame frame_;
    uint64_t origin_us_ = 0;
    double origin_height_ = 0.0;  // m, above mean sea level
    bool has_origin_ = false;
    bool has_origin_height_ = false;

    OutputCorrection output_correction_;
    bool jumped_ = false;  // the estimate was reset: the output follows at once
    uint64_t output_us_ = 0;
    VehicleLocalPosition resets_{};  // the counters and deltas of it
    EstimatorInnovations innovations_{};
    EstimatorStatus ratios_{};
};

}  // namespace stator::apps::navigation
