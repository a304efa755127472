// The command line of a simulated flight.
#include "world/options.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace stator::world {
namespace {

// Nothing on the standard error output, or the one line that was there.
std::string refusal(std::vector<const char*> arguments, Options& options) {
    arguments.insert(arguments.begin(), "program");
    const int count = static_cast<int>(arguments.size());
    testing::internal::CaptureStderr();
    const bool parsed = parse(count, arguments.data(), options);
    const std::string text = testing::internal::GetCapturedStderr();
    EXPECT_EQ(parsed, text.empty());
    return text;
}

TEST(Options, reads_all) {
    Options options;
    EXPECT_EQ(refusal({"--log", "a b.ulg", "--truth", "t", "--seed", "18446744073709551615",
                       "--duration", "2.5", "--times", "random", "--fail", "gnss_loss@2.5+10"},
                      options),
              "");
    EXPECT_STREQ(options.log, "a b.ulg");
    EXPECT_STREQ(options.truth, "t");
    EXPECT_EQ(options.conditions.seed, 18446744073709551615U);
    EXPECT_EQ(options.duration_us, 2500000U);
    EXPECT_TRUE(options.random_times);
    const Faults& faults = options.conditions.faults;
    EXPECT_FALSE(faults.now(FaultKind::kGnssLoss, 2499999));
    EXPECT_TRUE(faults.now(FaultKind::kGnssLoss, 2500000));
    EXPECT_FALSE(faults.now(FaultKind::kGnssLoss, 12500000));
}

TEST(Options, needs_none) {
    Options options;
    EXPECT_EQ(refusal({}, options), "");
    EXPECT_EQ(options.log, nullptr);
    EXPECT_FALSE(options.random_times);
}

TEST(Options, refuses_what_is_no_value) {
    for (const char* const duration : {"0", "-1", "nan", "inf", "1e7", "5s", "", " 5"}) {
        Options options;
        EXPECT_EQ(refusal({"--duration", duration}, options),
                  "error: --duration: expected seconds above 0 and up to 1000000, found '" +
                      std::string(duration) + "'\n");
    }
    for (const char* const seed : {"-1", "1.5", "x", "", "18446744073709551616"}) {
        Options options;
        EXPECT_EQ(refusal({"--seed", seed}, options),
                  "error: --seed: expected a whole number from 0 to 18446744073709551615, found '" +
                      std::string(seed) + "'\n");
    }
    Options options;
    EXPECT_EQ(refusal({"--times", "one"}, options),
              "error: --times: expected zero or random, found 'one'\n");
    EXPECT_EQ(refusal({"--seed"}, options),
              "error: --seed: expected a whole number from 0 to 18446744073709551615, found ''\n");
}

TEST(Options, reads_the_weather) {
    Options options;
    EXPECT_EQ(refusal({"--wind", "8.5", "--wind-from", "270", "--gusts", "moderate"}, options), "");
    EXPECT_EQ(options.conditions.wind.speed, 8.5);
    EXPECT_NEAR(options.conditions.wind.from, 4.71238898, 1e-8);
    EXPECT_EQ(options.conditions.wind.gusts, Gusts::kModerate);
    EXPECT_NE(refusal({"--wind", "-1"}, options), "");
    EXPECT_NE(refusal({"--wind", "51"}, options), "");
    EXPECT_NE(refusal({"--wind-from", "361"}, options), "");
    EXPECT_NE(refusal({"--wind-from", "west"}, options), "");
    EXPECT_EQ(refusal({"--gusts", "strong"}, options),
              "error: --gusts: expected none, light, moderate or severe, found 'strong'\n");
}

TEST(Options, varies_the_vehicle_if_asked) {
    Options options;
    EXPECT_FALSE(options.conditions.vary);
    EXPECT_EQ(refusal({"--vary", "yes"}, options), "");
    EXPECT_TRUE(options.conditions.vary);
    EXPECT_EQ(refusal({"--vary", "some"}, options),
              "error: --vary: expected no or yes, found 'some'\n");
}

TEST(Options, a_fault_has_a_value_and_lasts) {
    Options options;
    EXPECT_EQ(refusal({"--fail", "motor_3=0.25@1"}, options), "");
    EXPECT_EQ(options.conditions.faults.now("motor_3", FaultKind::kPartial, 1000000), 0.25);
    EXPECT_EQ(options.conditions.faults.now("motor_2", FaultKind::kPartial, 1000000), std::nullopt);
    EXPECT_TRUE(options.conditions.faults.now("motor_3", FaultKind::kPartial, 100000000));
}

TEST(Options, refuses_what_cannot_fail) {
    for (const char* const fault : {"gnss_loss", "gps@1", "gnss_loss@", "gnss_loss@-1", "@1", "",
                                    "gnss_loss=1@1", "motor_1=2@1", "rc_loss@1+", "rc_loss@1+x"}) {
        Options options;
        EXPECT_NE(refusal({"--fail", fault}, options), "") << fault;
    }
    Options options;
    for (int i = 0; i < 16; ++i) EXPECT_EQ(refusal({"--fail", "rc_loss@1"}, options), "");
    EXPECT_NE(refusal({"--fail", "rc_loss@1"}, options), "");
}

TEST(Options, refuses_a_pilot_that_is_not_there) {
    Options options;
    EXPECT_EQ(refusal({"--pilot", "/no/such/file"}, options),
              "error: --pilot '/no/such/file': No such file or directory\n");
}

TEST(Options, a_mission_and_a_speed_are_taken) {
    Options options;
    EXPECT_EQ(refusal({"--mission", "m", "--speed", "2.5"}, options), "");
    EXPECT_STREQ(options.mission, "m");
    EXPECT_EQ(options.speed, 2.5);
    EXPECT_NE(refusal({"--speed", "0"}, options), "");
    EXPECT_NE(refusal({"--mission", ""}, options), "");
}

TEST(Options, the_world_lies_where_it_is_told) {
    Options options;
    EXPECT_EQ(refusal({"--origin", "-33.5,151.25,12.5"}, options), "");
    EXPECT_EQ(options.conditions.earth.latitude_deg, -33.5);
    EXPECT_EQ(options.conditions.earth.longitude_deg, 151.25);
    EXPECT_EQ(options.conditions.earth.altitude_msl, 12.5);
    const Earth usual;
    Options without;
    EXPECT_EQ(refusal({"--origin", "59,10"}, without), "");
    EXPECT_EQ(without.conditions.earth.altitude_msl, usual.altitude_msl);
    for (const char* wrong :
         {"", "1", "1,", "91,0", "0,181", "0,0,99999", "0,0,x", "0,0,1,2", "nan,0"}) {
        EXPECT_NE(refusal({"--origin", wrong}, options), "") << wrong;
    }
}

TEST(Options, refuses_what_it_does_not_know) {
    Options options;
    EXPECT_EQ(refusal({"--sed", "1"}, options),
              "error: unknown option '--sed'\nhint: known: --log FILE, --truth FILE, --seed N, "
              "--duration SECONDS, --times zero|random, --budgets TASK=US,..., "
              "--vary no|yes, --wind M_S, "
              "--wind-from DEGREES, --gusts none|light|moderate|severe, --launch "
              "ground|catapult|hand, --fail "
              "WHAT@SECONDS, "
              "--pilot FILE, --vehicle FILE, --mission FILE, --origin LATITUDE,LONGITUDE[,HEIGHT], "
              "--speed FACTOR, --mavlink PLACE, --signing-key FILE, --hil PLACE, "
              "--lockstep SOCKET\n");
}

}  // namespace
}  // namespace stator::world
