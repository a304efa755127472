// The file of all parameters, against a reader that was written from the format alone.
#include "pack.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <string>
#include <vector>

#include "parameters.hpp"
#include "stator/testing.hpp"

namespace stator::apps::parameters {
namespace {

struct WingParams {
    uint64_t timestamp{};
    float cruise{};
    float speed{};
    int32_t whole{};
    bool inverted{};
    uint8_t padding[3]{};
};

constexpr ParameterRow kRows[] = {
    parameter::flag({"wing.inverted", "A", 4, 4}, 0, offsetof(WingParams, inverted), false),
    parameter::real({"wing.cruise", "MPC_XY_CRUISE", 1, 1}, 0, offsetof(WingParams, cruise), 0.0F,
                    20.0F, 5.0F),
    parameter::real({"wing.speed", "MPC_XY_VEL_MAX", 2, 2}, 0, offsetof(WingParams, speed), 0.0F,
                    20.0F, 10.0F),
    parameter::whole({"wing.whole", "MPC_XY_VEL_MAX_A", 3, 3}, 0, offsetof(WingParams, whole), -9,
                     9, 7),
};

ParameterBits bits(float value) {
    return std::bit_cast<ParameterBits>(value);
}

struct Known {
    std::string id;
    int type;
    ParameterBits value;
    ParameterBits standard;
    bool operator==(const Known&) const = default;
};

// As ground stations read it.
std::vector<Known> decoded(const std::vector<uint8_t>& file) {
    std::vector<Known> found;
    std::string before;
    std::size_t at = 6;
    const auto number = [&](unsigned count) {
        uint32_t value = 0;
        for (unsigned i = 0; i < count; ++i) value |= uint32_t{file.at(at++)} << 8 * i;
        return value;
    };
    while (at < file.size()) {
        const uint32_t head = number(2);
        before = before.substr(0, head >> 8 & 15U);
        const unsigned more = (head >> 12) + 1;
        for (unsigned i = 0; i < more; ++i) before += static_cast<char>(number(1));
        const uint32_t value = number(4);
        const uint32_t standard = (head & 0x10U) != 0 ? number(4) : value;
        found.push_back({before, static_cast<int>(head & 15U), value, standard});
    }
    return found;
}

struct PackTest : ::testing::Test {
    PackTest() {
        Output<WingParams> output;
        output.connect(topic.topic(), 0, false);
        output.publish([] { return WingParams{.cruise = 5.0F, .speed = 12.0F, .whole = -1}; });
    }

    FilePiece ask(FileRequest request) {
        now_us += 1000;
        request.tag = ++tag;
        ParametersPorts ports{.now = now_us, .file_request = Input(request)};
        ports.parameters.connect(table, now_us);
        stator::testing::Probe piece(ports.file, now_us);
        node.step(ports);
        EXPECT_EQ(piece.count(), 1U);
        EXPECT_EQ(piece.newest().tag, tag);
        return piece.newest();
    }
    std::vector<uint8_t> read(FileRequest request) {
        std::vector<uint8_t> file;
        while (true) {
            request.offset = static_cast<uint32_t>(file.size());
            const FilePiece piece = ask(request);
            EXPECT_EQ(piece.result, FilePiece::Result::kRead);
            file.insert(file.end(), piece.data.begin(), piece.data.begin() + piece.length);
            if (piece.length < request.length) {
                EXPECT_EQ(file.size(), piece.bytes);
                return file;
            }
        }
    }
    void set(const char* name, float value) {
        ParameterRequest request{.action = ParameterRequest::Action::kSet,
                                 .type = ParameterRequest::Type::kFloat,
                                 .float_value = value};
        std::memcpy(request.name.data(), name, std::strlen(name));
        ParametersPorts ports{.now = ++now_us, .request = Input(request)};
        ports.parameters.connect(table, now_us);
        stator::testing::Probe answer(ports.value, now_us);
        node.step(ports);
        EXPECT_EQ(answer.newest().result, ParameterValue::Result::kWritten);
    }

    stator::testing::LoneTopic<WingParams> topic;
    ParameterTopic topics[1]{{&topic.topic(), true}};
    ParameterTable table{.rows = kRows, .row_count = 4, .topics = topics, .topic_count = 1};
    Parameters node;
    uint64_t now_us = 0;
    uint8_t tag = 200;
};

const std::vector<Known> kAll{
    {"A", 3, 0, 0},
    {"MPC_XY_CRUISE", 4, bits(5.0F), bits(5.0F)},
    {"MPC_XY_VEL_MAX", 4, bits(12.0F), bits(10.0F)},
    {"MPC_XY_VEL_MAX_A", 3, 0xFFFFFFFFU, 7},
};

TEST_F(PackTest, IsReadAsItWasWrittenInPiecesOfEveryLength) {
    for (unsigned length = 1; length < 240; ++length) {
        const auto file = read(
            {.length = static_cast<uint8_t>(length), .with_defaults = true, .count = UINT16_MAX});
        ASSERT_EQ(decoded(file), kAll) << length;
    }
}

TEST_F(PackTest, DefaultsAreLeftOutWithoutTheOption) {
    std::vector<Known> expected = kAll;
    for (Known& known : expected) known.standard = known.value;
    EXPECT_EQ(decoded(read({.length = 80, .count = UINT16_MAX})), expected);
}

TEST_F(PackTest, BeginsWithMagicAndCounts) {
    const auto with = read({.length = 80, .with_defaults = true, .first = 1, .count = 2});
    EXPECT_EQ(std::vector(with.begin(), with.begin() + 6),
              (std::vector<uint8_t>{0x1C, 0x67, 2, 0, 4, 0}));
    EXPECT_EQ(decoded(with), std::vector(kAll.begin() + 1, kAll.begin() + 3));
    const auto without = read({.length = 80, .count = UINT16_MAX});
    // "A", then of MPC_XY_CRUISE nothing shared.
    EXPECT_EQ(std::vector(without.begin(), without.begin() + 15),
              (std::vector<uint8_t>{0x1B, 0x67, 4, 0, 4, 0, 3, 0, 'A', 0, 0, 0, 0, 4, 12 << 4}));
    EXPECT_EQ(read({.length = 80, .first = 9, .count = 5}).size(), 6U) << "none is left";
}

TEST_F(PackTest, HasTheValuesOfNowAndAnotherVersion) {
    const FileRequest size{.count = UINT16_MAX};
    const uint32_t before = ask(size).version;
    EXPECT_EQ(ask(size).version, before);
    set("wing.cruise", 6.0F);
    EXPECT_NE(ask(size).version, before);
    const auto file = read({.length = 239, .with_defaults = true, .count = UINT16_MAX});
    EXPECT_EQ(decoded(file)[1], (Known{"MPC_XY_CRUISE", 4, bits(6.0F), bits(5.0F)}));
}

TEST_F(PackTest, BehindItsEndThereIsNothing) {
    EXPECT_EQ(ask({.offset = UINT32_MAX, .length = 239, .count = UINT16_MAX}).length, 0);
    EXPECT_EQ(ask({.length = 255, .count = UINT16_MAX}).bytes,
              read({.length = 239, .count = UINT16_MAX}).size())
        << "a length over the most is not one over the end";
}

}  // namespace
}  // namespace stator::apps::parameters
