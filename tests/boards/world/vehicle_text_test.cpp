// The text that the compiler writes of a vehicle.
#include "world/vehicle_text.hpp"

#include <gtest/gtest.h>

#include "iris.hpp"

namespace stator::world {
namespace {

TEST(VehicleText, holds_the_vehicle_of_the_quad) {
    const Vehicle vehicle = iris();
    const Airframe& body = vehicle.airframe;
    EXPECT_EQ(body.mass, 1.535);
    EXPECT_EQ(body.inertia.zz, 0.055225);
    ASSERT_EQ(body.rotor_count(), 4U);
    EXPECT_EQ(body.rotors[2].place_B, Vector3(0.13, -0.22, 0.0));
    EXPECT_EQ(body.rotors[2].turns_ccw, -1.0);
    EXPECT_EQ(body.ground.feet, 4U);
    EXPECT_EQ(body.ground.points_B.size(), 8U);
    EXPECT_EQ(vehicle.battery.capacity_c, 18360.0);
}

TEST(VehicleText, says_which_line_is_wrong) {
    const auto wrong = [](const std::string& line) {
        Vehicle vehicle;
        return read_vehicle("mass 1.0\n" + line + "\n", vehicle);
    };
    constexpr const char* kExpected = "expected a key of a vehicle and its numbers, found '";
    for (const char* line : {"weight 1.0", "mass", "mass 1.0 2.0", "mass 1.x", "rotor 1 2 3",
                             "foot 1 2", "mass  1.0", "inertia 1 2 3 4 5 6"}) {
        EXPECT_EQ(wrong(line), kExpected + std::string(line) + "'");
    }
    EXPECT_EQ(wrong("cells 3.0"),
              "expected a mass, rotors or a wing, and feet or wheels, found a vehicle without");
    EXPECT_EQ(wrong("wing 1 1 1 0 0 0\nfoot 0 0 1"),
              "expected the curve of a stalled wing, found a wing without");
    EXPECT_EQ(wrong("shaft_power 1 2"), kExpected + std::string("shaft_power 1 2'"));
}

}  // namespace
}  // namespace stator::world
