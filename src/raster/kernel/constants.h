// SPDX-License-Identifier: MIT
//
// Every constant of the method, once, with its meaning and source.
// "3DGS" is Kerbl et al., 3D Gaussian Splatting for Real-Time Radiance Field Rendering, 2023.
#pragma once

namespace qs {

inline constexpr int kTileSize = 16;            ///< pixels along a tile's side; 3DGS
inline constexpr float kAlphaMin = 1.0f / 255;  ///< smaller contributions are skipped; 3DGS
inline constexpr float kAlphaMax = 0.99f;       ///< alpha is clamped to this; 3DGS
inline constexpr float kTransmittanceMin =
    1e-4f;  ///< a pixel stops before its transmittance falls below; 3DGS
inline constexpr double kDilation = 0.3;  ///< px^2 added to both variances, a low-pass filter; 3DGS
inline constexpr double kSlopeMargin =
    1.3;  ///< the Jacobian is evaluated inside 1.3 x the field of view; 3DGS
inline constexpr float kSigmas = 3.0f;  ///< half side of the 3DGS square in standard deviations
inline constexpr float kEigenvalueFloor = 0.1f;  ///< under the root of the 3DGS eigenvalue, px^4
inline constexpr double kCompensationFloor =
    2.5e-5;  ///< of the determinant ratio; Mip-Splatting (Yu et al. 2024)
inline constexpr float kExactSlack =
    1.0005f;  ///< on gamma in mode `exact`: rounding room, +0.03 % pairs
inline constexpr double kLn2 = 0.69314718055994530942;
inline constexpr double kLog2E = 1.44269504088896340736;
inline constexpr float kLog2Of255 = 7.994353436858858f;

/// 2^x on [-1/2, 1/2] as a polynomial: coefficients of x^1 to x^5, that of x^0 is 1. Fitted to the
/// smallest largest relative error, below 2e-7 in fp32.
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
