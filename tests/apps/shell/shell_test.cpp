// What a person types, and what is printed: without a graph, with tables made by hand.
#include "shell.hpp"

#include <gtest/gtest.h>

#include <deque>
#include <string>
#include <vector>

#include "stator/testing.hpp"

namespace stator::apps::shell {
namespace {

using Type = ParameterValue::Type;
using Result = ParameterValue::Result;

// A topic with one sample, published at will.
struct Wind {
    uint64_t timestamp{};
    float speed[3]{};
    int16_t count{};
    bool gusty{};
};

// The node, its tables, and the node with all parameters.
class ShellTest : public ::testing::Test {
  protected:
    ShellTest() { wind_.connect(topic_.topic(), 0, false); }

    void publish(const Wind& wind) {
        wind_.publish([&] { return wind; });
    }
    ShellText step(const ShellText& typed) {
        now_us_ += 10'000;
        ShellPorts ports{.now = now_us_,
                         .typed = Input(typed),
                         .value = value_ ? Input(*value_) : Input<ParameterValue>(),
                         .graph = &table_};
        stator::testing::Probe printed(ports.printed, now_us_, 1);
        std::optional<stator::testing::Probe<ParameterRequest>> request;
        if (has_parameters_) request.emplace(ports.request, now_us_, uint16_t{1});
        node_.step(ports);
        value_.reset();
        if (request && request->count() != 0) answer(request->newest());
        EXPECT_EQ(printed.count(), typed.wants_text ? 1U : 0U) << "each request has one answer";
        return printed.count() == 0 ? ShellText{} : printed.newest();
    }
    void type(const std::string& text, uint8_t console = 0, bool is_new = false) {
        for (std::size_t at = 0; at == 0 || at < text.size(); at += 70) {
            ShellText typed{.console = console, .is_new = is_new && at == 0};
            typed.length = static_cast<uint8_t>(std::min<std::size_t>(70, text.size() - at));
            std::copy_n(text.begin() + static_cast<std::ptrdiff_t>(at), typed.length,
                        typed.data.begin());
            step(typed);
        }
    }
    // One piece; true if there is more.
    bool print(std::string& text, uint8_t console = 0) {
        const ShellText printed = step({.console = console, .tag = ++tag_, .wants_text = true});
        EXPECT_EQ(printed.console, console);
        EXPECT_EQ(printed.tag, tag_);
        EXPECT_LE(printed.length, printed.data.size());
        text.append(printed.data.begin(), printed.data.begin() + printed.length);
        return printed.has_more;
    }
    std::string printed(uint8_t console = 0) {
        std::string text;
        for (unsigned i = 0; print(text, console); ++i) {
            if (i > 5000) return text + " (without an end)";
        }
        return text;
    }
    std::string say(const std::string& line, uint8_t console = 0) {
        type(line + "\n", console);
        return printed(console);
    }
    void answer(const ParameterRequest& request) {
        ++requests_;
        if (!answers_) return;
        const std::string name(reinterpret_cast<const char*>(request.name.data()));
        ParameterValue value{.requester = static_cast<ParameterValue::Requester>(request.requester),
                             .tag = request.tag,
                             .result = Result::kUnknown,
                             .count = 3};
        for (unsigned i = 0; i < 3; ++i) {
            Parameter& parameter = parameters_[i];
            if (name.empty() ? i != request.index : name != parameter.id) continue;
            const bool sets = request.action == ParameterRequest::Action::kSet;
            if (sets) {
                EXPECT_EQ(static_cast<int>(request.type), static_cast<int>(parameter.type));
                parameter.real = request.float_value;
                parameter.whole = request.int_value;
            }
            value.result = sets ? result_ : Result::kRead;
            value.type = parameter.type;
            value.index = static_cast<uint16_t>(i);
            value.float_value = parameter.real;
            value.int_value = parameter.whole;
            value.float_default = 0.5F;
            value.float_most = 2.0F;
            value.int_default = 1;
            std::copy(parameter.id.begin(), parameter.id.end(), value.id.begin());
            std::copy(parameter.id.begin(), parameter.id.end(), value.name.begin());
        }
        value_ = value;
    }

    struct Parameter {
        std::string id;
        Type type;
        float real = 0.5F;
        int32_t whole = 1;
    };
    std::array<Parameter, 3> parameters_{Parameter{"ALT_MAX", Type::kFloat},
                                         Parameter{"COUNT", Type::kInt32},
                                         Parameter{"USES_GPS", Type::kBool}};
    TaskCounters fast_{.activations = 4000, .lost_samples = 2, .latest_us = 31};
    TaskCounters slow_{.activations = 7};
    std::array<ObservedTask, 2> tasks_{ObservedTask{"fast_one", &fast_, 0, 12},
                                       ObservedTask{"slow_one", &slow_, 1, 1}};
    stator::testing::LoneTopic<Wind> topic_;
    std::array<ObservedTopic, 1> topics_{
        ObservedTopic{"wind", "uint64_t timestamp;float[3] speed;int16_t count;bool gusty;",
                      &topic_.topic(), 23}};
    GraphTable table_{tasks_.data(), 2, topics_.data(), 1};
    Output<Wind> wind_;
    std::optional<ParameterValue> value_;
    Result result_ = Result::kWritten;
    bool answers_ = true;
    bool has_parameters_ = true;
    unsigned requests_ = 0;
    uint64_t now_us_ = 990'000;
    uint8_t tag_ = 0;
    Shell node_;
};

TEST_F(ShellTest, a_console_begins_with_a_prompt_and_a_line_is_echoed) {
    type("", 0, true);
    EXPECT_EQ(printed(), "> ");
    EXPECT_EQ(say(""), "\n> ");
    EXPECT_EQ(say("fly"), "fly\nunknown command; `help` shows all\n> ");
    const std::string help = say("help");
    EXPECT_NE(help.find("param set NAME VALUE"), std::string::npos) << help;
    EXPECT_TRUE(help.ends_with("ends a command\n> ")) << help;
}

TEST_F(ShellTest, top_shows_each_task) {
    const std::string text = say("top");
    EXPECT_EQ(text,
              "top\n"
              "lev task                  count      /s     resp us  lost\n"
              "12  fast_one              4000       3921   31       2\n"
              "1   slow_one              7          6      0        0\n"
              "> ")
        << text;
}

TEST_F(ShellTest, listener_shows_a_sample_as_it_was_when_it_was_asked_for) {
    EXPECT_EQ(say("listener"), "listener\nwind\n> ");
    EXPECT_EQ(say("listener rain"), "listener rain\nunknown topic; `listener` shows all\n> ");
    EXPECT_EQ(say("listener wind"), "listener wind\nno sample yet\n> ");
    publish({.speed = {1.5F, -0.1F, 3e-7F}, .count = -4, .gusty = true});
    type("listener wind\n");
    std::string text;
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(print(text));
    publish({.speed = {9.0F, 9.0F, 9.0F}, .count = 9});
    text += printed();
    EXPECT_EQ(text,
              "listener wind\nsample 1\n  timestamp: 0\n  speed: 1.5 -0.1 3e-7\n  count: -4\n"
              "  gusty: true\n> ");
}

TEST_F(ShellTest, parameters_are_listed_read_and_set) {
    EXPECT_EQ(say("param list"),
              "param list\n"
              "  ALT_MAX           0.5         ALT_MAX\n"
              "  COUNT             1           COUNT\n"
              "  USES_GPS          true        USES_GPS\n> ");
    EXPECT_EQ(say("param list UN"), "param list UN\n  COUNT             1           COUNT\n> ");
    EXPECT_EQ(say("param list nothing"), "param list nothing\n> ");
    EXPECT_EQ(say("param get WHAT"),
              "param get WHAT\nunknown parameter; `param list` shows all\n> ");
    EXPECT_EQ(say("param set ALT_MAX 1.25"),
              "param set ALT_MAX 1.25\n* ALT_MAX           1.25 (graph: 0.5) ALT_MAX\n> ");
    EXPECT_EQ(parameters_[0].real, 1.25F);
    EXPECT_NE(say("param set COUNT -12").find("-12 (graph: 1)"), std::string::npos);
    EXPECT_NE(say("param set USES_GPS false").find("false (graph: true)"), std::string::npos);
    EXPECT_EQ(parameters_[2].whole, 0);
}

TEST_F(ShellTest, a_value_that_does_not_fit_changes_nothing_and_says_why) {
    EXPECT_EQ(say("param set COUNT 1.5"),
              "param set COUNT 1.5\nexpected a whole number, found '1.5'\n> ");
    EXPECT_EQ(say("param set ALT_MAX high"),
              "param set ALT_MAX high\nexpected a number, found 'high'\n> ");
    EXPECT_EQ(parameters_[0].real, 0.5F);
    EXPECT_EQ(say("param set COUNT"),
              "param set COUNT\nexpected list, get NAME, or set NAME VALUE\n> ");
    result_ = Result::kOutOfRange;
    EXPECT_EQ(say("param set ALT_MAX 3"), "param set ALT_MAX 3\nout of range: 0 to 2\n> ");
    result_ = Result::kArmed;
    EXPECT_EQ(say("param set COUNT 3"),
              "param set COUNT 3\nit changes only while the vehicle is disarmed\n> ");
    has_parameters_ = false;
    EXPECT_EQ(say("param list"), "param list\nthe graph has no node that changes parameters\n> ");
}

TEST_F(ShellTest, an_activation_asks_once_at_most) {
    for (int i = 0; i < 3; ++i) {
        type("param set COUNT 3\n", 0);
        type("param list nothing\n", 1);
        for (int k = 0; k < 20; ++k) {
            std::string text;
            const unsigned before = requests_;
            print(text, static_cast<uint8_t>(k % 2));
            EXPECT_LE(requests_, before + 1);
        }
    }
}

TEST_F(ShellTest, a_node_that_does_not_answer_ends_the_command) {
    answers_ = false;
    EXPECT_EQ(say("param get COUNT"),
              "param get COUNT\nno answer from the node with the parameters\n> ");
    answers_ = true;
    EXPECT_NE(say("param get COUNT").find("  COUNT"), std::string::npos);
}

TEST_F(ShellTest, ctrl_c_ends_a_command_and_forgets_what_waits) {
    type("param list\nhelp\nhel");
    std::string text;
    for (int i = 0; i < 3; ++i) print(text);
    type("\x03");
    EXPECT_EQ(printed(), "^C\n> ");
    EXPECT_EQ(say("p"), "p\nunknown command; `help` shows all\n> ");
}

TEST_F(ShellTest, a_line_is_put_together_from_pieces_and_mended_by_backspaces) {
    type("li");
    type("stenir\x7f\x7f");
    type("\x08\x08\x08\x08\x08\x08\x08\x08\x08listener\r");
    EXPECT_EQ(printed(), "listener\nwind\n> ");
    type("\n");
    EXPECT_EQ(printed(), "") << "a line that ended with both is one";
    EXPECT_EQ(say("\tlistener\xc3\xa4"), " listener??\nunknown command; `help` shows all\n> ");
}

TEST_F(ShellTest, a_line_that_is_too_long_is_lost_whole_and_the_next_one_counts) {
    std::string lines(500, 'x');
    lines += "\nlistener";
    const std::string text = say(lines);
    EXPECT_EQ(text, "a line was lost: too long, or typed too fast\n> listener\nwind\n> ");
}

TEST_F(ShellTest, lines_that_come_meanwhile_wait_and_a_flood_is_cut_at_lines) {
    std::string flood;
    for (int i = 0; i < 200; ++i) flood += "listener\n";
    type(flood);
    const std::string text = printed();
    std::size_t runs = 0;
    for (std::size_t at = 0; (at = text.find("listener\nwind\n> ", at)) != std::string::npos;
         ++at) {
        ++runs;
    }
    EXPECT_GE(runs, 10U);
    EXPECT_LE(runs, 20U);
    EXPECT_NE(text.find("a line was lost"), std::string::npos);
    EXPECT_EQ(text.find("unknown"), std::string::npos) << "no part of a line was taken for one";
}

TEST_F(ShellTest, two_consoles_do_not_see_each_other) {
    publish({.count = 1});
    type("listener wind\n", 0);
    type("listener wind\nparam list\n", 1);
    std::string first;
    std::string second;
    for (int i = 0; i < 60; ++i) {
        print(first, 0);
        print(second, 1);
    }
    const std::string sample =
        "listener wind\nsample 1\n  timestamp: 0\n  speed: 0 0 0\n  count: 1\n  gusty: false\n> ";
    EXPECT_EQ(first, sample);
    EXPECT_EQ(second.substr(0, sample.size()), sample);
    EXPECT_NE(second.find("USES_GPS"), std::string::npos);
}

TEST_F(ShellTest, a_console_that_begins_anew_leaves_nothing_behind) {
    publish({.count = 1});
    type("listener wind\n", 0);
    std::string text;
    for (int i = 0; i < 3; ++i) print(text);
    type("", 0, true);
    EXPECT_EQ(printed(), "> ");
    EXPECT_NE(say("listener wind", 1).find("gusty"), std::string::npos)
        << "the sample's buffer is free again";
}

TEST(Text, writes_reals_as_people_read_them) {
    const std::pair<double, const char*> cases[] = {{0.0, "0"},
                                                    {0.15F, "0.15"},
                                                    {-2.5, "-2.5"},
                                                    {1234567.0, "1234567"},
                                                    {12345678.0, "1.234568e7"},
                                                    {100.0, "100"},
                                                    {0.0001F, "0.0001"},
                                                    {9.9999999, "10"},
                                                    {1e-5F, "1e-5"},
                                                    {3.4028235e38F, "3.402823e38"},
                                                    {47.39, "47.39"},
                                                    {1.0 / 0.0, "inf"},
                                                    {0.0 / 0.0, "nan"},
                                                    {0.001234F, "0.001234"}};
    for (const auto& [value, expected] : cases) {
        Line line;
        line.put_real(value);
        std::array<uint8_t, 40> text{};
        const std::size_t count = line.take(text);
        EXPECT_EQ(std::string(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(count)),
                  expected);
    }
}

TEST(Text, reads_the_nearest_float) {
    for (const char* text : {"0.15", "3.1415927", "1e-3", "-12.5", ".5", "7.", "1E+3", "1e-38"}) {
        ASSERT_TRUE(read_real(text).has_value()) << text;
        EXPECT_EQ(*read_real(text), std::strtof(text, nullptr)) << text;
    }
    for (const char* text :
         {"", "-", ".", "1e", "1x", "e5", "1e99", "nan", "1.2.3", "--1", "1e50"}) {
        EXPECT_FALSE(read_real(text).has_value()) << text;
    }
    EXPECT_EQ(read_whole("-2147483648"), INT32_MIN);
    for (const char* text : {"", "-", "2147483648", "1.0", "99999999999", "a"}) {
        EXPECT_FALSE(read_whole(text).has_value()) << text;
    }
}

// Whatever is typed, the node stays within what it promises.
TEST_F(ShellTest, any_bytes_are_survived) {
    uint32_t random = 1;
    for (unsigned i = 0; i < 20'000; ++i) {
        ShellText typed{.console = static_cast<uint8_t>(i % 3)};
        random = random * 1664525U + 1013904223U;
        typed.length = static_cast<uint8_t>(random >> 24);
        typed.is_new = (random & 0xFF000U) == 0;
        for (uint8_t& c : typed.data) {
            random = random * 1664525U + 1013904223U;
            static constexpr std::string_view kLetters =
                "listener wind\nparam get set top help\x7f\r\x03 ";
            c = static_cast<uint8_t>(
                i % 2 == 0 ? random >> 24
                           : static_cast<uint8_t>(kLetters[(random >> 16) % kLetters.size()]));
        }
        step(typed);
        if (i % 3 < 2) {
            std::string text;
            print(text, static_cast<uint8_t>(i % 3));
        }
    }
    type("\x03\n");
    printed();
    EXPECT_EQ(say("listener"), "listener\nwind\n> ");
}

}  // namespace
}  // namespace stator::apps::shell
