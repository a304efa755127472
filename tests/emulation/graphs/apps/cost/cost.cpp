// Runs the navigation filter's operations, and those of geodesy, and counts their instructions.
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

// In double precision, which the chip does in software. Places from pole to pole, around the Earth.
void Cost::count_geodesy(double run) {
    const math::LatitudeLongitude origin{0.5 * run - 80.0, run - 170.0};
    math::LocalFrame frame;
    math::NorthEast local;
    math::LatitudeLongitude global;
    frame_ = larger(frame_, counted([&] { frame = math::LocalFrame(origin); }));
    const math::LatitudeLongitude place{origin.latitude_deg + 0.01, origin.longitude_deg - 0.02};
    local_ = larger(local_, counted([&] { local = frame.to_local(place); }));
    global_ = larger(global_, counted([&] { global = frame.from_local(local); }));
    asm volatile("" ::"m"(global));
}

void Cost::step(CostPorts& /*ports*/) {
    if (++runs_ > kRuns + kWindow) return;
    if (runs_ == 1) {
        // The defaults of the interface.
        params_ = {.gyro_noise = 0.001F,
                   .accel_noise = 0.07F,
                   .gyro_bias_walk = 2e-4F,
                   .accel_bias_walk = 1e-3F,
                   .gyro_bias_uncertainty = 0.03F,
                   .accel_bias_uncertainty = 0.05F,
                   .baro_drift = 0.015F,
                   .mag_offset_uncertainty = 0.3F,
                   .mag_offset_walk = 2e-3F};
        filter_.start(0, Quaternion::Identity(), 1e-3F, 1.0F, params_);
        window_.restart(0, {});
    }
    const float wave = static_cast<float>(runs_ % 16) - 8.0F;
    window_.add(Vector(0.1F * wave, 0.2F, -0.3F), Vector(wave, 1.0F, -9.8F), 0.008F);
    window_.close(time_us_ += 8000, filter_.bias());
    if (runs_ <= kWindow) return;
    reading_ = counted([] {});
    const MotionWindow::Step step = window_.take();
    predict_ = larger(predict_, counted([&] { filter_.predict(step, params_); }));
    const auto fuse = [&](const ObservationModel& model, bool keep_tilt) {
        return counted([&] { filter_.fuse(model, 0.001F * wave, 0.04F, 5.0F, keep_tilt); });
    };
    fuse_one_ = larger(fuse_one_, fuse({kVelocity}, false));
    fuse_two_ = larger(
        fuse_two_, fuse({static_cast<ErrorState>(kPosition + 2), -1.0F, kBaroOffset, 1.0F}, false));
    fuse_heading_ = larger(fuse_heading_, fuse({kHeading, 1.0F, kMagOffset, 1.0F}, true));
    Kinematics now;
    output_ = larger(output_, counted([&] { now = moved(filter_.kinematics(), window_.ahead()); }));
    asm volatile("" ::"m"(now));
    count_geodesy(static_cast<double>(runs_));
    if (runs_ != kRuns + kWindow) return;
    for (const uint32_t most :
         {predict_, fuse_one_, fuse_two_, fuse_heading_, output_, frame_, local_, global_}) {
        semihosting::print(most - reading_);
        semihosting::print("\n");
    }
    semihosting::exit(0);
}

}  // namespace stator::apps::cost
