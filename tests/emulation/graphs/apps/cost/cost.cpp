// Runs the navigation filter's operations and counts their instructions.
#include "cost.hpp"

#include "../../../../../boards/qemu_f405/semihosting.hpp"
#include "../../counting.hpp"

namespace stator::apps::cost {

namespace {

constexpr uint32_t kRuns = 300;
constexpr uint32_t kWindow = 25;  // steps between the horizon and now

// What `work` takes. Nothing moves across the readings, which are volatile, but what has no effect
// outside: the filter is a member.
template <class Work>
uint32_t counted(Work work) {
    const uint32_t begin = counting::kCount.read();
    asm volatile("" ::: "memory");
    work();
    asm volatile("" ::: "memory");
    const uint32_t end = counting::kCount.read();
    return end - begin;
}

uint32_t larger(uint32_t a, uint32_t b) {
    return a > b ? a : b;
}

}  // namespace

void Cost::step(CostPorts& /*ports*/) {
    if (++runs_ > kRuns + kWindow) return;
    if (runs_ == 1) {
        // The defaults of the interface.
        params_ = {.gyro_noise = 0.001f,
                   .accel_noise = 0.07f,
                   .gyro_bias_walk = 2e-4f,
                   .accel_bias_walk = 1e-3f,
                   .gyro_bias_uncertainty = 0.03f,
                   .accel_bias_uncertainty = 0.05f,
                   .baro_drift = 0.015f,
                   .mag_offset_uncertainty = 0.3f,
                   .mag_offset_walk = 2e-3f};
        filter_.start(0, Quaternion::Identity(), 1e-3f, 1.0f, params_);
        window_.restart(0, {});
    }
    const float wave = static_cast<float>(runs_ % 16) - 8.0f;
    window_.add(Vector(0.1f * wave, 0.2f, -0.3f), Vector(wave, 1.0f, -9.8f), 0.008f);
    window_.close(time_us_ += 8000, filter_.bias());
    if (runs_ <= kWindow) return;
    reading_ = counted([] {});
    const MotionWindow::Step step = window_.take();
    predict_ = larger(predict_, counted([&] { filter_.predict(step, params_); }));
    const auto fuse = [&](const Sight& sight, bool keep_tilt) {
        return counted([&] { filter_.fuse(sight, 0.001f * wave, 0.04f, 5.0f, keep_tilt); });
    };
    fuse_one_ = larger(fuse_one_, fuse({kVelocity}, false));
    fuse_two_ = larger(
        fuse_two_, fuse({static_cast<ErrorState>(kPosition + 2), -1.0f, kBaroOffset, 1.0f}, false));
    fuse_heading_ = larger(fuse_heading_, fuse({kHeading, 1.0f, kMagOffset, 1.0f}, true));
    Kinematics now;
    output_ = larger(output_, counted([&] { now = moved(filter_.kinematics(), window_.ahead()); }));
    asm volatile("" ::"m"(now));
    if (runs_ != kRuns + kWindow) return;
    for (const uint32_t most : {predict_, fuse_one_, fuse_two_, fuse_heading_, output_}) {
        semihosting::print(most - reading_);
        semihosting::print("\n");
    }
    semihosting::exit(0);
}

}  // namespace stator::apps::cost
