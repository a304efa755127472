// Polynomials and constants of the functions in this folder. Written by
// fit_coefficients.py, which says how; clang-format wraps the lines.
#pragma once

#include <cstdint>

#include "detail/double_word.hpp"

namespace stator::math::detail {

// 64 zero bits, then 2/pi from its first binary digit after the point on.
inline constexpr std::uint32_t kTwoOverPi[] = {
    0x00000000, 0x00000000, 0xa2f9836e, 0x4e441529, 0xfc2757d1, 0xf534ddc0, 0xdb629599, 0x3c439041,
    0xfe5163ab, 0xdebbc561, 0xb7246e3a, 0x424dd2e0, 0x06492eea, 0x09d1921c, 0xfe1deb1c, 0xb129a73e,
    0xe88235f5, 0x2ebb4484, 0xe99c7026, 0xb45f7e41, 0x3991d639, 0x835339f4, 0x9c845f8b, 0xbdf9283b,
    0x1ff897ff, 0xde05980f, 0xef2f118b, 0x5a0a6d1f, 0x6d367ecf, 0x27cb09b7, 0x4f463f66, 0x9e5fea2d,
    0x7527bac7, 0xebe5f17b, 0x3d0739f7, 0x8a5292ea, 0x6bfb5fb1, 0x1f8d5d08, 0x56033046, 0xfc7b6bab};

template <std::floating_point T>
struct Coefficients;

template <>
struct Coefficients<float> {
    // (sin r - r) / r^3 in r^2, |r| <= pi/4. Error 2^-32.3.
    static constexpr float kSin[] = {-0x1.555556p-3F, 0x1.111166p-7F, -0x1.a04a82p-13F,
                                     0x1.786ae6p-19F};
    // (cos r - 1 + r^2/2) / r^4 in r^2, |r| <= pi/4. Error 2^-33.1.
    static constexpr float kCos[] = {0x1.55554ap-5F, -0x1.6c0c2ep-10F, 0x1.99eadp-16F};
    // (atan t - t) / t^3 in t^2, |t| <= tan(pi/8). Error 2^-33.7.
    static constexpr float kAtan[] = {-0x1.555554p-2F, 0x1.9998b2p-3F,  -0x1.247588p-3F,
                                      0x1.c39ec8p-4F,  -0x1.5764dap-4F, 0x1.767e7ep-5F};
    // (asin x - x) / x^3 in x^2, |x| <= 1/2. Error 2^-31.7.
    static constexpr float kAsin[] = {0x1.55554cp-3F, 0x1.33389ap-4F, 0x1.6cabap-5F,
                                      0x1.04a60cp-5F, 0x1.d82adcp-7F, 0x1.339b94p-5F};
    // (exp r - 1 - r) / r^2 in r, |r| <= log(2)/2. Error 2^-33.1.
    static constexpr float kExp[] = {0x1p-1F,        0x1.555556p-3F,  0x1.5554e4p-5F,
                                     0x1.110feep-7F, 0x1.6d514ep-10F, 0x1.a27408p-13F};
    // (log((1+s)/(1-s)) - 2s) / s^3 in s^2, (1+s)/(1-s) in [sqrt(1/2), sqrt(2)]. Error 2^-35.0.
    static constexpr float kLog[] = {0x1.555554p-1F, 0x1.999bd4p-2F, 0x1.23f1ap-2F, 0x1.ec1e42p-3F};
    // the same less 2/3 + 2/5 s^2, by s^4. Error 2^-42.9.
    static constexpr float kLogRest[] = {0x1.2492bep-2F, 0x1.c69c54p-3F, 0x1.8abf7p-3F};
    // As sums; kLn2's first part leaves room for an exact product with an exponent.
    static constexpr DoubleWord<float> kPi{0x1.921fb6p+1F, -0x1.777a5cp-24F};
    static constexpr DoubleWord<float> kHalfPi{0x1.921fb6p+0F, -0x1.777a5cp-25F};
    static constexpr DoubleWord<float> kQuarterPi{0x1.921fb6p-1F, -0x1.777a5cp-26F};
    static constexpr DoubleWord<float> kLn2{0x1.62e4p-1F, 0x1.7f7d1cp-20F};
    static constexpr DoubleWord<float> kTwoThirds{0x1.555556p-1F, -0x1.555556p-26F};
    static constexpr DoubleWord<float> kTwoFifths{0x1.99999ap-2F, -0x1.99999ap-28F};
    static constexpr float kHalfPiParts[] = {0x1.922p+0F, -0x1.2afp-18F, 0x1.0b4612p-34F};
    static constexpr float kTwoOverPiRounded = 0x1.45f306p-1F;
    static constexpr float kLog2E = 0x1.715476p+0F;
};

template <>
struct Coefficients<double> {
    // (sin r - r) / r^3 in r^2, |r| <= pi/4. Error 2^-62.9.
    static constexpr double kSin[] = {-0x1.5555555555555p-3,  0x1.1111111111089p-7,
                                      -0x1.a01a01a0065ccp-13, 0x1.71de3a3f68e4fp-19,
                                      -0x1.ae643c57ca552p-26, 0x1.61140fec19a79p-33,
                                      -0x1.a513850a48725p-41};
    // (cos r - 1 + r^2/2) / r^4 in r^2, |r| <= pi/4. Error 2^-64.0.
    static constexpr double kCos[] = {0x1.555555555554bp-5,  -0x1.6c16c16c1504bp-10,
                                      0x1.a01a019c97777p-16, -0x1.27e4f7f8eae3ap-22,
                                      0x1.1ee9e15f38979p-29, -0x1.8fa9952065738p-37};
    // (atan t - t) / t^3 in t^2, |t| <= tan(pi/8). Error 2^-63.8.
    static constexpr double kAtan[] = {
        -0x1.5555555555554p-2, 0x1.99999999995bcp-3, -0x1.2492492471fb3p-3, 0x1.c71c71b5e75aep-4,
        -0x1.745d148f016b4p-4, 0x1.3b136ae1cc8b7p-4, -0x1.110c478ab4619p-4, 0x1.e16f050dbdfeep-5,
        -0x1.ab6c0b3eb306fp-5, 0x1.70ac22b3f75eap-5, -0x1.11ab92fd47ef9p-5, 0x1.efd749fcbb81p-7};
    // (asin x - x) / x^3 in x^2, |x| <= 1/2. Error 2^-63.7.
    static constexpr double kAsin[] = {
        0x1.5555555555553p-3,  0x1.33333333339d7p-4, 0x1.6db6db6d4dba5p-5,  0x1.f1c71ca62329bp-6,
        0x1.6e8b9b3481269p-6,  0x1.1c4f80135ad8dp-6, 0x1.c9817886701dep-7,  0x1.7b9e67cfb9ea2p-7,
        0x1.36eaf7c896752p-7,  0x1.47480ce0dce89p-7, 0x1.8bdbc107ad8a5p-11, 0x1.9429a76996149p-6,
        -0x1.a91e63c319ddcp-6, 0x1.12aa0f89cfaa7p-5};
    // (exp r - 1 - r) / r^2 in r, |r| <= log(2)/2. Error 2^-63.8.
    static constexpr double kExp[] = {0x1p-1,
                                      0x1.555555555555cp-3,
                                      0x1.5555555555558p-5,
                                      0x1.111111110e9eep-7,
                                      0x1.6c16c16c1500ap-10,
                                      0x1.a01a01b44bb2bp-13,
                                      0x1.a01a01ad776cfp-16,
                                      0x1.71ddee5f22b42p-19,
                                      0x1.27e4cc2648232p-22,
                                      0x1.af6ea400fd05cp-26,
                                      0x1.1f8bb5e5ff35ap-29};
    // (log((1+s)/(1-s)) - 2s) / s^3 in s^2, (1+s)/(1-s) in [sqrt(1/2), sqrt(2)]. Error 2^-66.6.
    static constexpr double kLog[] = {
        0x1.5555555555555p-1, 0x1.9999999999d0ap-2, 0x1.249249243a361p-2, 0x1.c71c724a82c6fp-3,
        0x1.745ce20ffd0bcp-3, 0x1.3b2018a521d73p-3, 0x1.0f68463bb8667p-3, 0x1.0f05040883d52p-3};
    // the same less 2/3 + 2/5 s^2, by s^4. Error 2^-72.7.
    static constexpr double kLogRest[] = {
        0x1.24924924927fdp-2, 0x1.c71c71c651dadp-3, 0x1.745d17dbd5914p-3, 0x1.3b1376f7e586p-3,
        0x1.111dfe221c85cp-3, 0x1.de97111a4e323p-4, 0x1.e81c50a693471p-4};
    // As sums; kLn2's first part leaves room for an exact product with an exponent.
    static constexpr DoubleWord<double> kPi{0x1.921fb54442d18p+1, 0x1.1a62633145c07p-53};
    static constexpr DoubleWord<double> kHalfPi{0x1.921fb54442d18p+0, 0x1.1a62633145c07p-54};
    static constexpr DoubleWord<double> kQuarterPi{0x1.921fb54442d18p-1, 0x1.1a62633145c07p-55};
    static constexpr DoubleWord<double> kLn2{0x1.62e42fefa38p-1, 0x1.ef35793c7673p-45};
    static constexpr DoubleWord<double> kTwoThirds{0x1.5555555555555p-1, 0x1.5555555555555p-55};
    static constexpr DoubleWord<double> kTwoFifths{0x1.999999999999ap-2, -0x1.999999999999ap-56};
    static constexpr double kHalfPiParts[] = {0x1.921fb544p+0, 0x1.0b4611a6p-34,
                                              0x1.3198a2e037073p-69};
    static constexpr double kTwoOverPiRounded = 0x1.45f306dc9c883p-1;
    static constexpr double kLog2E = 0x1.71547652b82fep+0;
};

}  // namespace stator::math::detail
