// Consoles over SERIAL_CONTROL, as QGroundControl, MAVSDK and MAVProxy open them.
#include "harness.hpp"

namespace stator::apps::mavlink {
namespace {

namespace flag = mav::serial_control_flag;
constexpr mav::Address kOther{254, 190};

class ConsolesTest : public MavlinkTest {
  protected:
    // `flags`: QGroundControl's, unless given.
    void type(const std::string& text, mav::Address from = kGround, unsigned line = 0,
              uint8_t flags = flag::kRespond | flag::kExclusive | flag::kMulti) {
        for (std::size_t at = 0; at == 0 || at < text.size(); at += 70) {
            mav::SerialControl message{.device = 10, .flags = flags};
            message.count = static_cast<uint8_t>(std::min<std::size_t>(70, text.size() - at));
            std::copy_n(text.begin() + static_cast<std::ptrdiff_t>(at), message.count,
                        message.data.begin());
            send(message, line, from);
        }
    }
    // What was printed for this station; each reply is one for it.
    std::string printed(mav::Address to = kGround, unsigned line = 0) const {
        std::string text;
        for (const auto& reply : heard<mav::SerialControl>(line)) {
            EXPECT_EQ(reply.device, 10);
            EXPECT_EQ(reply.flags, flag::kReply);
            EXPECT_NE(reply.count, 0);
            if (reply.target_system != to.system || reply.target_component != to.component)
                continue;
            text.append(reply.data.begin(), reply.data.begin() + reply.count);
        }
        return text;
    }
};

TEST_F(ConsolesTest, what_is_typed_comes_to_the_shell_and_back) {
    std::string text = "listener vehicle_attitude\n";
    text.resize(text.size() + 200, 'x');
    type(text);
    run(0.5);
    EXPECT_EQ(printed(), text);
    EXPECT_EQ(new_consoles_, 1U);
    type("more");
    run(0.2);
    EXPECT_EQ(printed(), text + "more");
    EXPECT_EQ(new_consoles_, 1U);
}

TEST_F(ConsolesTest, an_idle_console_costs_nothing) {
    type("top\n");
    run(1.0);
    const unsigned before = wants_;
    for (int i = 0; i < 10; ++i) {
        type("");  // as MAVProxy polls
        run(0.2);
    }
    EXPECT_EQ(wants_, before);
    EXPECT_EQ(printed(), "top\n");
}

TEST_F(ConsolesTest, two_stations_have_a_console_each_and_a_third_waits) {
    is_open_[1] = true;
    type("one");
    type("two", kOther, 1);
    run(0.5);
    type("three", {253, 190});
    run(0.5);
    EXPECT_EQ(printed(), "one");
    EXPECT_EQ(printed(kOther, 1), "two");
    EXPECT_EQ(printed(kOther, 0), "");
    EXPECT_EQ(printed({253, 190}), "all consoles are in use: try in 10 s\n");
    run(10.0);
    forget();
    type("again");  // the first one is still there
    type("three", {253, 190});
    run(0.5);
    EXPECT_EQ(printed(), "again");
    EXPECT_EQ(printed({253, 190}), "three");
    EXPECT_EQ(new_consoles_, 3U) << "the third one got the place of the silent one";
}

TEST_F(ConsolesTest, a_console_that_is_closed_is_free_at_once) {
    type("one");
    type("two", kOther);
    run(0.5);
    type("", kOther, 0, 0);
    type("three", {253, 190});
    run(0.5);
    EXPECT_EQ(printed({253, 190}), "three");
}

TEST_F(ConsolesTest, a_slow_line_loses_nothing) {
    line_.bytes_per_s = 1200;
    std::string text;
    for (int i = 0; i < 100; ++i) text += std::to_string(i) + " ";
    for (std::size_t at = 0; at < text.size(); at += 70) {
        type(text.substr(at, 70));
        run(0.1);
    }
    run(5.0);
    EXPECT_EQ(printed(), text);
}

TEST_F(ConsolesTest, what_is_not_for_the_shell_has_no_reply) {
    mav::SerialControl message{.device = 10, .flags = flag::kRespond, .count = 3};
    message.target_system = 9;
    send(message);
    message.target_system = 0;
    message.device = 2;  // a receiver's port
    send(message);
    message.device = 10;
    message.flags = flag::kReply;
    send(message);
    run(0.5);
    EXPECT_EQ(printed(), "");
    EXPECT_EQ(new_consoles_, 0U);
}

TEST_F(ConsolesTest, a_radio_has_no_console) {
    params_.role1 = static_cast<int32_t>(Role::kRadio);
    type("param list\n");
    run(0.5);
    EXPECT_EQ(printed(), "no console on this line\n");
    EXPECT_EQ(new_consoles_, 0U);
}

TEST_F(ConsolesTest, a_count_beyond_the_data_is_cut) {
    mav::SerialControl message{.device = 10, .flags = flag::kRespond, .count = 255};
    message.data.fill('y');
    send(message);
    run(0.5);
    EXPECT_EQ(printed(), std::string(70, 'y'));
}

TEST_F(ConsolesTest, a_flood_is_cut_and_the_heartbeat_stays) {
    for (int i = 0; i < 300; ++i) {
        type(std::string(70, 'z'));
        step();
    }
    EXPECT_GE(heard<mav::Heartbeat>().size(), 3U);
    forget();
    run(20.0);
    forget();
    type("listener\n");
    run(0.5);
    EXPECT_EQ(printed(), "listener\n");
}

TEST_F(ConsolesTest, a_shell_that_is_silent_is_asked_again) {
    shell_answers_ = false;
    type("top");
    run(2.0);
    EXPECT_GE(wants_, 3U);
    EXPECT_LE(wants_, 6U);
    shell_answers_ = true;
    run(1.0);
    EXPECT_EQ(printed(), "top");
}

}  // namespace
}  // namespace stator::apps::mavlink
