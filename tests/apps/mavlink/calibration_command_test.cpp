// PREFLIGHT_CALIBRATION, and the lines that tell a person what to do.
#include "harness.hpp"

namespace stator::apps::mavlink {
namespace {

using Action = CalibrationRequest::Action;
namespace cmd = mav::mav_cmd;
namespace result = mav::mav_result;

class CalibrationCommandTest : public MavlinkTest {
  protected:
    int ask(std::array<float, 7> p) {
        forget();
        send_command(cmd::kPreflightCalibration, p);
        run(0.1);
        const auto found = results(cmd::kPreflightCalibration);
        EXPECT_EQ(found.size(), 1U) << "one answer";
        return found.empty() ? -1 : found.front();
    }
};

TEST_F(CalibrationCommandTest, each_has_its_parameter) {
    const std::pair<std::array<float, 7>, Action> cases[] = {{{1}, Action::kGyro},
                                                             {{0, 1}, Action::kMag},
                                                             {{0, 0, 0, 0, 1}, Action::kAccel},
                                                             {{0, 0, 0, 0, 2}, Action::kLevel},
                                                             {{}, Action::kCancel}};
    for (const auto& [p, action] : cases) {
        EXPECT_EQ(ask(p), result::kAccepted);
        ASSERT_FALSE(calibrations_.empty());
        EXPECT_EQ(calibrations_.back().action, action);
    }
    EXPECT_EQ(calibrations_.size(), std::size(cases));
}

TEST_F(CalibrationCommandTest, what_there_is_not_is_unsupported) {
    const float nan = math::canonical_nan<float>();
    const std::array<float, 7> cases[] = {
        {0, 0, 1}, {0, 0, 0, 1}, {0, 0, 0, 0, 4}, {0, 0, 0, 0, 0, 1},
        {1, 1},    {2},          {nan},           {0, 0, 0, 0, nan, 0, 1}};
    for (const auto& p : cases) EXPECT_EQ(ask(p), result::kUnsupported);
    EXPECT_TRUE(calibrations_.empty());
}

TEST_F(CalibrationCommandTest, only_disarmed_and_one_at_a_time) {
    calibrating_.is_running = true;
    EXPECT_EQ(ask({1}), result::kTemporarilyRejected);
    EXPECT_EQ(ask({}), result::kAccepted) << "it can be cancelled";
    calibrating_.is_running = false;
    status_.arming_state = VehicleStatus::ArmingState::kArmed;
    EXPECT_EQ(ask({1}), result::kTemporarilyRejected);
    EXPECT_EQ(calibrations_.size(), 1U);
}

TEST_F(CalibrationCommandTest, all_stations_get_the_lines) {
    is_open_[1] = true;
    run(0.1);
    notice_ = StatusText{.severity = StatusText::Severity::kInfo};
    constexpr std::string_view kText = "[cal] progress <37>";
    std::copy(kText.begin(), kText.end(), notice_->text.begin());
    run(0.1);
    for (unsigned line = 0; line < 2; ++line) {
        const auto texts = heard<mav::Statustext>(line);
        ASSERT_EQ(texts.size(), 1U);
        EXPECT_EQ(std::string(texts[0].text.data()), kText);
        EXPECT_EQ(texts[0].severity, mav::mav_severity::kInfo);
    }
}

}  // namespace
}  // namespace stator::apps::mavlink
