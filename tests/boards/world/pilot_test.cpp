// The pilot of a simulated flight, and what his script may say.
#include "world/pilot.hpp"

#include <gtest/gtest.h>

namespace stator::world {
namespace {

TEST(Pilot, arms_after_a_second_and_leaves_the_sticks_alone) {
    const Pilot pilot;
    EXPECT_FALSE(pilot.frame(999999).arm);
    EXPECT_TRUE(pilot.frame(1000000).arm);
    EXPECT_EQ(pilot.frame(1000000).throttle, 0.0F);
    EXPECT_EQ(pilot.frame(1000000).mode_slot, 1U);
}

TEST(Pilot, follows_a_script) {
    Pilot pilot;
    EXPECT_EQ(pilot.follow("# seconds roll pitch yaw throttle slot arm return kill\n"
                           "2.5 0.5 -1 0 1 3 1 0 0\r\n"
                           "\n"
                           "4 0 0 0 0 6 1 1 0  # home"),
              "");
    EXPECT_EQ(pilot.frame(0).roll, 0.0F);
    EXPECT_FALSE(pilot.frame(2499999).arm);
    EXPECT_EQ(pilot.frame(2500000).roll, 0.5F);
    EXPECT_EQ(pilot.frame(2500000).pitch, -1.0F);
    EXPECT_EQ(pilot.frame(3999999).mode_slot, 3U);
    EXPECT_TRUE(pilot.frame(4000000).return_home);
    EXPECT_FALSE(pilot.frame(9000000).kill);
}

TEST(Pilot, refuses_a_script_with_the_line_and_keeps_its_own) {
    Pilot pilot;
    for (const char* const line :
         {"1 0 0 0 0 1 1 0", "1 0 0 0 0 1 1 0 0 0", "1 0 0 0 1.5 1 1 0 0", "1 0 0 0 0 7 1 0 0",
          "1 0 0 0 0 1 2 0 0", "1 0 0 0 0 1.5 1 0 0", "x 0 0 0 0 1 1 0 0", "-1 0 0 0 0 1 1 0 0"}) {
        const std::string wrong = pilot.follow(std::string("\n") + line);
        EXPECT_EQ(wrong.substr(0, 8), "line 2: ") << line;
    }
    EXPECT_EQ(pilot.follow("2 0 0 0 0 1 1 0 0\n1 0 0 0 0 1 1 0 0"),
              "line 2: expected a time not before that of the line above");
    EXPECT_TRUE(pilot.frame(1000000).arm);
}

}  // namespace
}  // namespace stator::world
