#include "pixhawk.hpp"

#include <cmath>

#include "att_pos_mocap.hpp"
#include "chip/spi.hpp"
#include "chip/timer.hpp"
#include "chip/usart.hpp"
#include "world/ending.hpp"
#include "world/truth.hpp"

namespace stator::plant {

namespace {

using chip::pin;

constexpr const char* kMocapLine = "UART8";
// Of the speed controllers, which the vehicle's user has set so: docs/boards.md.
constexpr double kMinPulse_us = 1075.0;
constexpr double kMaxPulse_us = 1950.0;

struct Output {
    unsigned timer;
    unsigned channel;  // from 0
    unsigned pin;
};
// AUX 1 to 6; the rotors' order is that of the allocation.
constexpr std::array<Output, 6> kOutputs{{{1, 3, pin('E', 14)},
                                          {1, 2, pin('E', 13)},
                                          {1, 1, pin('E', 11)},
                                          {1, 0, pin('E', 9)},
                                          {4, 1, pin('D', 13)},
                                          {4, 2, pin('D', 14)}}};

}  // namespace

Pixhawk::Pixhawk(chip::Chip& chip, const world::Options& options, std::FILE* truth)
    : chip_(chip),
      world_(options.conditions, options.vehicle),
      sensors_(world_),
      imu_(chip, pin('D', 15), [this](uint64_t) { return motion(); }),
      duration_us_(options.duration_us),
      truth_(truth),
      truth_is_whole_(truth == nullptr || world::write_truth_head(truth, world_)) {
    chip.spi("SPI1").attach(imu_, pin('C', 2));
    controls_.fill(kStopped);
    for (const unsigned timer : {1U, 4U}) {
        chip.timer(timer).watch([this, timer](unsigned channel, uint64_t high_ns, uint64_t) {
            for (unsigned i = 0; i < kOutputs.size(); ++i) {
                const bool is_it = kOutputs[i].timer == timer && kOutputs[i].channel == channel;
                if (is_it) pulse(i, high_ns);
            }
        });
    }
    chip.at(0, [this] { step(); });
}

// An event of the world, at its time.
void Pixhawk::step() {
    if (is_over_) return;
    world_.move_to_next_event();
    samples_.mocap0.is_new = 0;
    sensors_.measure(world_, samples_);
    apply_faults();
    if (samples_.mocap0.is_new != 0) send_mocap();
    record_truth();
    is_over_ = world_.is_over() || world_.next_event_us() > duration_us_ ||
               world::ending_signal.load() != 0;
    chip_.at(world_.next_event_us() * 1000, [this] { step(); });
}

// Of the part, besides what its samples show.
void Pixhawk::apply_faults() {
    const auto has = [&](world::FaultKind kind) {
        return world_.conditions().faults.now("imu0", kind, world_.time_us()).has_value();
    };
    imu_.faults.is_silent = has(world::FaultKind::kDropOut);
    imu_.faults.is_stuck = has(world::FaultKind::kStuck);
}

// Along the part's axes: it hangs below the board, its x to the left and its y to the front, so
// that a body's x, y, z are its y, -x, z.
chip::Mpu6000::Motion Pixhawk::motion() const {
    const auto turned = [](const std::array<float, 3>& body) -> std::array<double, 3> {
        return {-body[1], body[0], body[2]};
    };
    const auto& sample = samples_.imu0.sample;
    return {.rate = turned(sample.gyro_B), .force = turned(sample.accel_B)};
}

void Pixhawk::send_mocap() {
    const auto& seen = samples_.mocap0.sample;
    const auto frame =
        att_pos_mocap(mocap_messages_++, seen.timestamp_sample, seen.position_N, seen.yaw);
    chip_.usart(kMocapLine).arrive(frame);
}

// A speed controller knows the width when the pulse ends, and sees none while the pin is held low.
void Pixhawk::pulse(unsigned output, uint64_t high_ns) {
    if (high_ns == 0 || !chip_.pins().is_high(kOutputs[output].pin)) return;
    const auto end = [this, output, high_ns] {
        const double width_us = static_cast<double>(high_ns) * 1e-3;
        const double control = (width_us - kMinPulse_us) / (kMaxPulse_us - kMinPulse_us);
        controls_[output] = control < 0.0 ? kStopped : static_cast<float>(control);
        world_.command_motors(chip_.now_ns() / 1000, controls_);
    };
    chip_.at(chip_.now_ns() + high_ns, end, chip::Effect::kUnseen);
}

void Pixhawk::record_truth() {
    if (truth_ == nullptr || world_.time_us() % world::kTruthPeriod_us != 0) return;
    truth_is_whole_ = world::write_truth(truth_, world_) && truth_is_whole_;
}

}  // namespace stator::plant
