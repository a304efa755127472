// A simulated sensor that no board's code and no file of the world names: a driver's folder and a
// line in board.yaml are enough.
#include <gtest/gtest.h>

#include "hand_over.hpp"
#include "iris.hpp"
#include "sensors.hpp"
#include "stator/virtual.hpp"
#include "tasks.hpp"

namespace stator {

namespace board {

namespace {

world::World the_world{world::Conditions{}, world::iris()};
Sensors sensors(the_world);

// As sitl does.
struct Give {
    template <class Device, class Sample>
    void operator()(Device& device, const Sample& sample, Line& line) const {
        device = sample;
        line.raise();
    }
    template <class Device, class Sample>
    void operator()(Device& device, const Sample& sample) const {
        device.put(sample);
    }
};

}  // namespace

uint64_t next_event_us() {
    return the_world.next_event_us();
}
void advance(uint64_t now_us) {
    while (next_event_us() <= now_us) {
        the_world.move_to_next_event();
        Samples samples;
        sensors.measure(the_world, samples);
        hand_over(samples, Give{});
    }
}

}  // namespace board

namespace {

TEST(NewSensor, is_fed_by_the_world) {
    start();
    board::the_world.command_motors(0, {0.7F, 0.7F, 0.7F, 0.7F});
    run_until(999'999);
    EXPECT_EQ(tasks::range0::state.counters.activations, 20U);
    EXPECT_EQ(board::range0.timestamp_sample, 950'000U);
    const auto height = static_cast<float>(-board::the_world.plant().state().position_N.z());
    EXPECT_GT(height, 0.5F);  // else it says nothing
    EXPECT_EQ(board::range1.get().value.distance, height);
    EXPECT_EQ(board::range1.get().count, 1000U);
}

}  // namespace
}  // namespace stator
