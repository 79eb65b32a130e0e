// SPDX-License-Identifier: MIT
//
// The constants of the method with their meaning and source.
// "3DGS" is Kerbl et al., 3D Gaussian Splatting for Real-Time Radiance Field Rendering, 2023.
#pragma once

namespace qs {

inline constexpr int kTileSize = 16;  ///< pixels along a tile's side; 3DGS

/// The thresholds of compositing (3DGS) in double precision, for mode reference.
namespace fp64 {
inline constexpr double kAlphaMin = 1.0 / 255;     ///< smaller contributions are skipped
inline constexpr double kAlphaMax = 0.99;          ///< alpha is clamped to this
inline constexpr double kTransmittanceMin = 1e-4;  ///< a pixel stops before it falls below this
}  // namespace fp64
inline constexpr auto kAlphaMin = static_cast<float>(fp64::kAlphaMin);
inline constexpr auto kAlphaMax = static_cast<float>(fp64::kAlphaMax);
inline constexpr auto kTransmittanceMin = static_cast<float>(fp64::kTransmittanceMin);

/// px^2 added to both variances as a low-pass filter, unless a frame sets another value; 3DGS.
inline constexpr double kDilation = 0.3;
/// The Jacobian is evaluated inside 1.3 x the field of view; 3DGS.
inline constexpr double kSlopeMargin = 1.3;
inline constexpr float kSigmas = 3.0f;  ///< half side of the 3DGS square in standard deviations
/// Lower bound under the root of the 3DGS eigenvalue, px^4.
inline constexpr float kEigenvalueFloor = 0.1f;
/// Lower bound of the determinant ratio; Mip-Splatting (Yu et al. 2024).
inline constexpr double kCompensationFloor = 2.5e-5;
/// Factor on gamma in mode `exact` against rounding; adds 0.03 % pairs.
inline constexpr float kExactSlack = 1.0005f;

inline constexpr double kLn2 = 0.69314718055994530942;
inline constexpr double kLog2E = 1.44269504088896340736;
inline constexpr float kLog2Of255 = 7.994353436858858f;

/// A solid ellipse is a Gaussian of this log2 of the opacity, whose alpha is clamped. With the
/// standard deviation sqrt(kSolidVariance) R, log2 of alpha is 64 - 65 (r / R)^2 at the distance r:
/// alpha is 0.99 up to 0.992 R, 1/2 at R, and below 1/255 from 1.053 R on.
inline constexpr float kSolidLog2 = 64;
inline constexpr double kSolidVariance = 1 / (2 * kLn2 * (double{kSolidLog2} + 1));
/// Gamma of a solid ellipse; other Gaussians have at most 11.1.
inline constexpr float kSolidGamma = 2.0f * static_cast<float>(kLn2) * (kSolidLog2 + kLog2Of255);
/// Two solid ellipses leave 1e-4 of a pixel's light, so rounding would decide whether it stops at
/// kTransmittanceMin. With this it stops everywhere.
inline constexpr double kSolidTransmittanceMin = 1.001e-4;

/// log2 of a Gaussian's falloff is this times d^T conic d; at alpha = 1/255 that form is gamma.
inline constexpr float kLog2OfFalloff = -0.5f * static_cast<float>(kLog2E);
/// Slack on log2 of the falloff when blending skips pixels with alpha < 1/255.
inline constexpr float kLog2Slack = 0.05f;
/// Bound of the relative rounding error of the falloff's terms, which cancel on thin Gaussians.
inline constexpr float kFalloffRounding = 4e-6f;

/// Polynomial for 2^x on [-1/2, 1/2]: coefficients of x^1 to x^5; the coefficient of x^0 is 1. A
/// minimax fit with a relative error below 2e-7 in fp32.
inline constexpr float kExp2C1 = 0.6931470036506653f;
inline constexpr float kExp2C2 = 0.24022242426872253f;
inline constexpr float kExp2C3 = 0.05550733581185341f;
inline constexpr float kExp2C4 = 0.009671512991189957f;
inline constexpr float kExp2C5 = 0.001326472731307149f;
inline constexpr float kRoundToInteger = 12582912.0f;  ///< 1.5 * 2^23: adding it rounds a float

/// Real spherical harmonics, degrees 0..3, in the order and with the signs of 3DGS.
inline constexpr double kSh0 = 0.28209479177387814;
inline constexpr double kSh1 = 0.4886025119029199;
inline constexpr double kSh2A = 1.0925484305920792;   ///< xy, -yz, -xz
inline constexpr double kSh2B = 0.31539156525252005;  ///< 2zz - xx - yy
inline constexpr double kSh2C = 0.5462742152960396;   ///< xx - yy
inline constexpr double kSh3A = 0.5900435899266435;   ///< -y (3xx - yy), -x (xx - 3yy)
inline constexpr double kSh3B = 2.890611442640554;    ///< xyz
inline constexpr double kSh3C = 0.4570457994644658;   ///< -y (4zz - xx - yy), -x (4zz - xx - yy)
inline constexpr double kSh3D = 0.3731763325901154;   ///< z (2zz - 3xx - 3yy)
inline constexpr double kSh3E = 1.445305721320277;    ///< z (xx - yy)

}  // namespace qs
