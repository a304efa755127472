// Over a link that loses, adds and changes bytes, everything arrives whole and soon. The time is
// the vehicle's, and the same in every run.
#include <functional>
#include <map>
#include <random>

#include "harness.hpp"
#include "log_transfer.hpp"
#include "mission_transfer.hpp"
#include "parameter_transfer.hpp"

namespace stator::apps::mavlink {
namespace {

class BadLinkTest : public MavlinkTest {
  protected:
    static constexpr uint64_t kAgain_us = 300'000;  // until the station asks again
    static constexpr uint64_t kEnds_us = 120'000'000;

    BadLinkTest() {
        for (unsigned i = 0; i < 200; ++i) {
            parameters_.push_back({"P" + std::to_string(1000 + i), ParameterValue::Type::kFloat,
                                   static_cast<float>(i), 0});
        }
        logs_.emplace_back();
        for (unsigned i = 0; i < 60'000; ++i) logs_[0].push_back(draw(256));
    }

    uint8_t draw(unsigned count) { return static_cast<uint8_t>(random_() % count); }
    bool happens(double part) { return static_cast<double>(random_()) < part * 0x1p32; }

    // What the link makes of it.
    template <class Message>
    void say(const Message& message) {
        mav::FrameBytes frame;
        frame.put(message, stations_[0].sequence++, kGround);
        std::vector<uint8_t> arriving(frame.bytes().begin(), frame.bytes().end());
        if (happens(lost_)) arriving.clear();
        if (!arriving.empty() && happens(flipped_)) {
            const std::size_t at = random_() % arriving.size();
            arriving[at] ^= static_cast<uint8_t>(1U << draw(8));
        }
        std::deque<uint8_t>& out = stations_[0].out;
        if (happens(garbage_)) {
            // A start of a frame that claims a length of 255 is the worst garbage.
            out.insert(out.end(), {0xFD, 0xFF});
            for (unsigned i = 1U + draw(40); i > 0; --i) out.push_back(draw(256));
        }
        out.insert(out.end(), arriving.begin(), arriving.end());
    }

    // The station: asks, takes what arrives, and asks again after a silence, until it has all. The
    // result is how long that took.
    double seconds_until(const std::function<bool()>& is_done, const std::function<void()>& ask,
                         const std::function<bool(const Heard&)>& take) {
        const uint64_t begin_us = now_us_;
        uint64_t asked_us = now_us_;
        ask();
        while (!is_done() && now_us_ - begin_us < kEnds_us) {
            forget();
            step();
            for (const Heard& message : stations_[0].heard) {
                if (!happens(lost_) && take(message)) asked_us = now_us_;
            }
            if (is_done() || now_us_ - asked_us < kAgain_us) continue;
            asked_us = now_us_;
            ask();
        }
        return static_cast<double>(now_us_ - begin_us) * 1e-6;
    }

    // Puts a hundred items on the vehicle and reads them back, each in so many seconds.
    void exchange_items(double limit_s) {
        constexpr uint16_t kItems = 100;
        const auto item = [](uint16_t seq) {
            return mav::MissionItemInt{.param2 = 2.0F,
                                       .param4 = math::canonical_nan<float>(),
                                       .x = 474'000'000 + 45 * seq,
                                       .y = 85'000'000,
                                       .z = 6.0F + static_cast<float>(seq),
                                       .seq = seq,
                                       .command = 16,
                                       .target_system = 1,
                                       .target_component = 1,
                                       .frame = mav::mav_frame::kGlobalRelativeAltInt,
                                       .autocontinue = 1};
        };
        std::optional<uint16_t> wanted;
        std::optional<int> outcome;
        const auto offer = [&] {
            if (wanted) {
                say(item(*wanted));
            } else {
                say(mav::MissionCount{.count = kItems, .target_system = 1, .target_component = 1});
            }
        };
        const auto serve = [&](const Heard& message) {
            if (message.id == mav::MissionAck::kId) outcome = message.as<mav::MissionAck>().type;
            if (message.id != mav::MissionRequestInt::kId) return false;
            wanted = message.as<mav::MissionRequestInt>().seq;
            say(item(*wanted));
            return true;
        };
        EXPECT_LE(seconds_until([&] { return outcome.has_value(); }, offer, serve), limit_s);
        EXPECT_EQ(outcome, static_cast<int>(mav::mav_mission_result::kAccepted));

        std::optional<uint16_t> count;
        std::vector<mav::MissionItemInt> items;
        const auto ask = [&] {
            if (!count) {
                say(mav::MissionRequestList{.target_system = 1, .target_component = 1});
            } else {
                say(mav::MissionRequestInt{.seq = static_cast<uint16_t>(items.size()),
                                           .target_system = 1,
                                           .target_component = 1});
            }
        };
        const auto take = [&](const Heard& message) {
            if (message.id == mav::MissionCount::kId && !count) {
                count = message.as<mav::MissionCount>().count;
            } else if (message.id == mav::MissionItemInt::kId &&
                       message.as<mav::MissionItemInt>().seq == items.size()) {
                items.push_back(message.as<mav::MissionItemInt>());
            } else {
                return false;
            }
            if (items.size() < *count) ask();
            return true;
        };
        EXPECT_LE(seconds_until([&] { return count && items.size() == *count; }, ask, take),
                  limit_s);
        ASSERT_EQ(items.size(), kItems);
        for (uint16_t i = 0; i < kItems; ++i) {
            EXPECT_EQ(items[i].x, item(i).x);
            EXPECT_EQ(items[i].y, item(i).y);
            EXPECT_EQ(items[i].z, item(i).z);
            EXPECT_EQ(items[i].command, item(i).command);
            EXPECT_EQ(items[i].frame, item(i).frame);
        }
    }
    double lost_ = 0.1;      // of all messages, both ways
    double garbage_ = 0.05;  // of those to the vehicle come behind garbage
    double flipped_ = 0.02;  // of those to the vehicle have one bit flipped
    std::mt19937 random_{1};
};

TEST_F(BadLinkTest, AllParametersArrive) {
    std::map<uint16_t, mav::ParamValue> values;
    bool is_listed = false;
    const auto ask = [&] {
        if (!is_listed) {
            say(mav::ParamRequestList{.target_system = 1, .target_component = 1});
            return;
        }
        unsigned asked = 0;
        for (uint16_t i = 0; i < parameters_.size() && asked < 10; ++i) {
            if (values.contains(i)) continue;
            ++asked;
            say(mav::ParamRequestRead{
                .param_index = static_cast<int16_t>(i), .target_system = 1, .target_component = 1});
        }
    };
    const auto take = [&](const Heard& message) {
        if (message.id != mav::ParamValue::kId) return false;
        const auto value = message.as<mav::ParamValue>();
        is_listed = true;
        values[value.param_index] = value;
        return true;
    };
    EXPECT_LE(seconds_until([&] { return values.size() == parameters_.size(); }, ask, take), 10.0);
    ASSERT_EQ(values.size(), parameters_.size());
    for (const auto& [index, value] : values) {
        EXPECT_EQ(std::string(value.param_id.data()), parameters_.at(index).id);
        EXPECT_EQ(value.param_value, parameters_.at(index).real);
    }
}

TEST_F(BadLinkTest, AHundredItemsGoThereAndBack) {
    exchange_items(30.0);
}

TEST_F(BadLinkTest, AHundredItemsGoThereAndBackOverAGoodLink) {
    lost_ = garbage_ = flipped_ = 0.0;
    exchange_items(10.0);
}

TEST_F(BadLinkTest, TheBeginningOfALogArrives) {
    constexpr uint32_t kBytes = 9216;
    std::map<uint32_t, std::vector<uint8_t>> parts;
    const auto length = [&] {  // without a gap
        uint32_t bytes = 0;
        while (bytes < kBytes && parts.contains(bytes)) {
            bytes += static_cast<uint32_t>(parts[bytes].size());
        }
        return bytes;
    };
    const auto ask = [&] {
        say(mav::LogRequestData{.ofs = length(),
                                .count = kBytes - length(),
                                .id = 0,
                                .target_system = 1,
                                .target_component = 1});
    };
    const auto take = [&](const Heard& message) {
        if (message.id != mav::LogData::kId) return false;
        const auto data = message.as<mav::LogData>();
        parts[data.ofs] = {data.data.begin(), data.data.begin() + data.count};
        // Behind the last message it asks for the first gap at once.
        if (data.ofs + data.count >= kBytes && length() < kBytes) ask();
        return true;
    };
    EXPECT_LE(seconds_until([&] { return length() >= kBytes; }, ask, take), 20.0);
    std::vector<uint8_t> log;
    for (const auto& [offset, bytes] : parts) log.insert(log.end(), bytes.begin(), bytes.end());
    ASSERT_EQ(log.size(), kBytes);
    EXPECT_TRUE(std::ranges::equal(log, std::span(logs_[0]).first(kBytes)));
}

}  // namespace
}  // namespace stator::apps::mavlink
