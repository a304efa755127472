// What a fault makes of a sensor's samples.
#include "world/spoiler.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "iris.hpp"

namespace stator::world {
namespace {

struct Sample {
    std::uint64_t timestamp_sample = 0;
    std::array<float, 3> xyz{};
    float temperature = 0.0F;

    template <class Visit>
    void each_quantity(Visit&& visit) {
        visit("field", std::span<float>(xyz));
    }
};

Fault read(const char* text) {
    const auto fault = read_fault(text);
    EXPECT_TRUE(fault) << text;
    return fault.value_or(Fault{});
}

std::array<float, 3> spoiled(const char* text, std::array<float, 3> xyz, std::uint64_t now_us) {
    math::Random random(1, 1);
    spoil_quantity(read(text), "field", std::span<float>(xyz), now_us, random);
    return xyz;
}

using Values = std::array<float, 3>;
constexpr std::uint64_t kSecond = 1'000'000;

TEST(SpoilQuantity, AddsAnOffsetToAllAxesOrToOne) {
    EXPECT_EQ(spoiled("mag0.field_offset=2@1", {1, 2, 3}, kSecond), (Values{3, 4, 5}));
    EXPECT_EQ(spoiled("mag0.field_y_offset=2@1", {1, 2, 3}, kSecond), (Values{1, 4, 3}));
    EXPECT_EQ(spoiled("mag0.offset=-1@1", {1, 2, 3}, kSecond), (Values{0, 1, 2}));
}

TEST(SpoilQuantity, LeavesOtherQuantitiesAlone) {
    EXPECT_EQ(spoiled("mag0.other_offset=2@1", {1, 2, 3}, kSecond), (Values{1, 2, 3}));
}

TEST(SpoilQuantity, DriftsWithTheTimeSinceItsStart) {
    EXPECT_EQ(spoiled("mag0.drift=0.5@1", {1, 2, 3}, 5 * kSecond), (Values{3, 4, 5}));
}

TEST(SpoilQuantity, CutsTurnsRoundAndExchanges) {
    EXPECT_EQ(spoiled("mag0.saturation=2@1", {1, -3, 3}, kSecond), (Values{1, -2, 2}));
    EXPECT_EQ(spoiled("mag0.wrong_sign@1", {1, 2, 3}, kSecond), (Values{-1, -2, -3}));
    EXPECT_EQ(spoiled("mag0.swapped_axis@1", {1, 2, 3}, kSecond), (Values{2, 1, 3}));
}

TEST(SpoilQuantity, NoiseAndSpikesAreDrawn) {
    math::Random random(1, 1);
    const Fault noise = read("mag0.noise=2@1");
    const Fault spikes = read("mag0.spike=7@1");
    double squares = 0.0;
    int hit = 0;
    constexpr int kMany = 20'000;
    for (int i = 0; i < kMany; ++i) {
        std::array<double, 1> value{0.0};
        spoil_quantity(noise, "field", std::span<double>(value), kSecond, random);
        squares += value[0] * value[0];
        value[0] = 0.0;
        spoil_quantity(spikes, "field", std::span<double>(value), kSecond, random);
        EXPECT_TRUE(value[0] == 0.0 || value[0] == 7.0);
        hit += value[0] != 0.0;
    }
    EXPECT_NEAR(std::sqrt(squares / kMany), 2.0, 0.05);
    EXPECT_NEAR(hit / static_cast<double>(kMany), 0.01, 0.003);
}

// A sensor that measures every 10 ms, its own time as its value.
class SpoilerTest : public ::testing::Test {
  protected:
    void start(std::initializer_list<const char*> faults) {
        Conditions conditions;
        for (const char* text : faults) ASSERT_TRUE(conditions.faults.add(read(text)));
        world_.emplace(conditions, iris());
        spoiler_.emplace(*world_, "mag0");
    }
    // The samples that come until then: when, and when they were measured.
    std::vector<std::pair<std::uint64_t, std::uint64_t>> run_until(std::uint64_t end_us) {
        std::vector<std::pair<std::uint64_t, std::uint64_t>> came;
        for (; now_us_ < end_us; now_us_ += 10'000) {
            while (world_->time_us() < now_us_) world_->move_to_next_event();
            Sample sample{.timestamp_sample = now_us_};
            sample.xyz.fill(static_cast<float>(now_us_));
            const auto given = spoiler_->spoil(sample, *world_);
            if (given) came.emplace_back(now_us_, static_cast<std::uint64_t>(given->xyz[0]));
        }
        return came;
    }
    std::optional<World> world_;
    std::optional<Spoiler<Sample>> spoiler_;
    std::uint64_t now_us_ = 10'000;
};

TEST_F(SpoilerTest, PassesWhatIsSoundOn) {
    start({"baro0.stuck@0"});
    for (const auto& [when, measured] : run_until(100'000)) EXPECT_EQ(when, measured);
}

TEST_F(SpoilerTest, StuckRepeatsTheLastSampleUntilItEnds) {
    start({"mag0.stuck@0.05+0.05"});
    const auto came = run_until(150'000);
    ASSERT_EQ(came.size(), 14U);
    EXPECT_EQ(came[6].second, 40'000U);
    EXPECT_EQ(came[8].second, 40'000U);
    EXPECT_EQ(came[10].second, came[10].first);
}

TEST_F(SpoilerTest, DropOutGivesNothing) {
    start({"mag0.drop_out@0.05+0.03"});
    EXPECT_EQ(run_until(100'000).size(), 6U);
}

TEST_F(SpoilerTest, DelayedSamplesComeLateAndEndWithTheFault) {
    start({"mag0.delay=0.04@0.1+0.2"});
    bool is_late = false;
    for (const auto& [when, measured] : run_until(600'000)) {
        is_late |= when == measured + 40'000;
        if (when < 100'000 || when >= 300'000) {
            EXPECT_EQ(when, measured);
        }
    }
    EXPECT_TRUE(is_late);
}

}  // namespace
}  // namespace stator::world
