//! A still picture of solids: perspective, hidden surfaces, one light, outlines, shadows on the floor.

use super::solid::Solid;
use super::style::{GRID, WHITE};
use crate::math::Vec3;
use plotters::style::RGBColor;

/// Tangent of half the angle of view across the picture's shorter side.
const HALF_VIEW: f64 = 0.27;
/// Direction towards the light in the eye's frame: right, up, towards the eye.
const LIGHT: [f64; 3] = [-0.45, 0.75, 0.55];
/// Brightness of a surface that the light does not reach.
const AMBIENT: f64 = 0.58;
/// Brightness of the floor in a shadow.
const SHADOW: f32 = 0.80;
/// Brightness of outlines.
const OUTLINE: f32 = 0.45;
/// Lines of the floor, m: distance and half width.
const FLOOR_GRID_M: (f64, f64) = (0.5, 0.004);

/// Where the picture is taken from; everything that must be seen is inside.
#[derive(Debug, Clone, Copy)]
pub(super) struct Eye {
    at: Vec3,
    /// Unit vectors to the right, up, and away from the eye.
    right: Vec3,
    up: Vec3,
    away: Vec3,
    /// Pixels of a tangent of one.
    scale: f64,
    middle: [f64; 2],
}

impl Eye {
    /// An eye in direction `from` of the points, near enough that they fill the picture (px).
    pub(super) fn fitted(from: Vec3, points: &[Vec3], (width, height): (u32, u32)) -> Self {
        let away = -from.normalize();
        let right = away.cross(&Vec3::z()).try_normalize(1e-9).unwrap_or_else(Vec3::x);
        let up = right.cross(&away);
        let [width, height] = [f64::from(width), f64::from(height)];
        let scale = 0.5 * width.min(height) / HALF_VIEW;
        let half = [0.5 * width / scale, 0.5 * height / scale];
        // In the eye's frame a point is seen if |x - x_eye| <= half (z - z_eye): for each side the
        // tightest point decides, and the eye is where both pairs of sides just hold.
        let of = |axis: &Vec3, half: f64| {
            let side = |sign: f64| {
                let tight = points.iter().map(|p| sign * p.dot(axis) - half * p.dot(&away));
                tight.fold(f64::NEG_INFINITY, f64::max)
            };
            let [plus, minus] = [side(1.0), side(-1.0)];
            (0.5 * (plus - minus), -0.5 * (plus + minus) / half)
        };
        let [(x, z_x), (y, z_y)] = [of(&right, half[0]), of(&up, half[1])];
        let at = right * x + up * y + away * z_x.min(z_y);
        Self { at, right, up, away, scale, middle: [0.5 * width, 0.5 * height] }
    }

    /// A point's place in the picture (px from the upper left corner) and its distance along the view.
    pub(super) fn seen(&self, p: &Vec3) -> ([f64; 2], f64) {
        let d = p - self.at;
        let far = d.dot(&self.away);
        let [x, y] = [&self.right, &self.up].map(|axis| self.scale * d.dot(axis) / far);
        ([self.middle[0] + x, self.middle[1] - y], far)
    }

    /// Direction of the light through a pixel's middle, as a line on which `away` is one.
    fn ray(&self, x: usize, y: usize) -> Vec3 {
        let [dx, dy] = [x as f64 + 0.5 - self.middle[0], self.middle[1] - y as f64 - 0.5];
        self.away + (self.right * dx + self.up * dy) / self.scale
    }

    fn light(&self) -> Vec3 {
        (self.right * LIGHT[0] + self.up * LIGHT[1] - self.away * LIGHT[2]).normalize()
    }
}

/// A corner of a triangle as it is seen.
#[derive(Clone, Copy)]
struct Corner {
    at: [f64; 2],
    /// One over the distance: linear in the picture.
    near: f64,
    light: f64,
}

/// What the eye sees at a pixel.
#[derive(Clone, Copy)]
struct Seen {
    near: f32,
    /// Number of the thing; 0 for the floor and beyond.
    thing: u16,
    /// The last veil before it; 0 for none.
    veil: u16,
    color: [f32; 3],
}

/// A picture under work.
pub(super) struct Canvas {
    eye: Eye,
    width: usize,
    height: usize,
    pixels: Vec<Seen>,
    shadow: Vec<bool>,
    things: u16,
    veils: u16,
}

impl Canvas {
    /// Nothing but white.
    pub(super) fn new(eye: Eye, (width, height): (u32, u32)) -> Self {
        let [width, height] = [width as usize, height as usize];
        let blank = Seen { near: 0.0, thing: 0, veil: 0, color: rgb(WHITE) };
        Self {
            eye,
            width,
            height,
            pixels: vec![blank; width * height],
            shadow: vec![false; width * height],
            things: 0,
            veils: 0,
        }
    }

    /// A thing of one or more solids, outlined as a whole, with its shadow on the floor.
    pub(super) fn thing(&mut self, solids: &[Solid], color: RGBColor) {
        self.things += 1;
        let (thing, color) = (self.things, rgb(color));
        let light = self.eye.light();
        for solid in solids {
            let shades: Vec<f64> =
                solid.corners.iter().map(|[_, n]| shade(n.dot(&light))).collect();
            self.fill(
                solid,
                |p| p,
                &shades,
                |pixel, _, near, light| {
                    if near > pixel.near {
                        *pixel = Seen { near, thing, veil: 0, color: color.map(|c| c * light) };
                    }
                },
            );
            self.cast(solid, &light);
        }
    }

    /// Something through which the rest is seen, `opacity` 0 to 1, without outline or shadow; it leaves
    /// things from number `clear` on as they are.
    pub(super) fn veil(&mut self, solids: &[Solid], clear: usize, color: RGBColor, opacity: f32) {
        let color = rgb(color);
        self.veils += 1;
        let veil = self.veils;
        for solid in solids {
            let shades = vec![1.0; solid.corners.len()];
            self.fill(
                solid,
                |p| p,
                &shades,
                |pixel, _, near, _| {
                    let is_clear = usize::from(pixel.thing) > clear;
                    if pixel.veil == veil || is_clear || near <= pixel.near {
                        return;
                    }
                    pixel.veil = veil;
                    for (below, above) in pixel.color.iter_mut().zip(color) {
                        *below += opacity * (above - *below);
                    }
                },
            );
        }
    }

    /// Darkens the floor where a solid keeps the light from it.
    fn cast(&mut self, solid: &Solid, light: &Vec3) {
        // A low light would throw shadows out of the picture.
        let fall = Vec3::new(light.x, light.y, light.z.max(0.6));
        let shades = vec![1.0; solid.corners.len()];
        let mut shadow = std::mem::take(&mut self.shadow);
        let onto_floor = |p: Vec3| p - fall * (p.z / fall.z);
        self.fill(solid, onto_floor, &shades, |_, at, _, _| shadow[at] = true);
        self.shadow = shadow;
    }

    /// Visits all pixels of a solid: pixel, its index, one over the distance, light.
    fn fill(
        &mut self,
        solid: &Solid,
        place: impl Fn(Vec3) -> Vec3,
        shades: &[f64],
        mut visit: impl FnMut(&mut Seen, usize, f32, f32),
    ) {
        let corners: Vec<Corner> = (solid.corners.iter().zip(shades))
            .map(|([p, _], &light)| {
                let (at, far) = self.eye.seen(&place(*p));
                Corner { at, near: 1.0 / far, light }
            })
            .collect();
        for triangle in &solid.triangles {
            let t = triangle.map(|i| corners[i]);
            // Nothing that must be seen is behind the eye; what is, is left out whole.
            if t.iter().any(|c| !(c.near > 0.0 && c.near < 1e3)) {
                continue;
            }
            let [a, b, c] = t.map(|c| c.at);
            let twice_area = cross(a, b, c);
            // The far side of what is closed is hidden behind its near side.
            if twice_area.abs() < 1e-9 || (solid.is_closed && twice_area > 0.0) {
                continue;
            }
            let rows = {
                let all = [a[1], b[1], c[1]];
                let low = all.iter().copied().fold(f64::INFINITY, f64::min).floor();
                let high = all.iter().copied().fold(f64::NEG_INFINITY, f64::max).ceil();
                let end = self.height as f64;
                low.clamp(0.0, end) as usize..high.clamp(0.0, end) as usize
            };
            // Weights of the corners are linear along a row: where all are positive, the row is inside.
            let slopes = [b[1] - c[1], c[1] - a[1], a[1] - b[1]].map(|v| v / twice_area);
            let along = |of: fn(&Corner) -> f64| {
                t.iter().zip(slopes).map(|(corner, slope)| of(corner) * slope).sum::<f64>()
            };
            let (near_step, light_step) = (along(|c| c.near), along(|c| c.light));
            for y in rows {
                let p = [0.5, y as f64 + 0.5];
                let w = [cross(p, b, c), cross(a, p, c), cross(a, b, p)].map(|v| v / twice_area);
                let Some(columns) = inside(&w, &slopes, self.width) else { continue };
                let at_left = |of: fn(&Corner) -> f64| {
                    t.iter().zip(w).map(|(corner, w)| of(corner) * w).sum::<f64>()
                };
                let (near, light) = (at_left(|c| c.near), at_left(|c| c.light));
                for x in columns {
                    let (right, at) = (x as f64, y * self.width + x);
                    let near = (near + right * near_step) as f32;
                    visit(&mut self.pixels[at], at, near, (light + right * light_step) as f32);
                }
            }
        }
    }

    /// How many pixels show the things from one number on (0: the first).
    pub(super) fn visible(&self, from: usize) -> usize {
        self.pixels.iter().filter(|p| usize::from(p.thing) > from).count()
    }

    /// How many things there are so far.
    pub(super) fn things(&self) -> usize {
        usize::from(self.things)
    }

    /// The floor, its grid and the shadows on it, where nothing stands; from `middle` (m) it fades away
    /// over `reach` (m). Veils come after it.
    pub(super) fn floor(&mut self, middle: Vec3, reach: f64) {
        let grid = rgb(GRID).map(|c| 0.88 * c);
        for y in 0..self.height {
            for x in 0..self.width {
                let at = y * self.width + x;
                let ray = self.eye.ray(x, y);
                let far = -self.eye.at.z / ray.z;
                if self.pixels[at].thing > 0 || !(far > 0.0 && far.is_finite()) {
                    continue;
                }
                let p = self.eye.at + ray * far;
                let away = ((p.x - middle.x).hypot(p.y - middle.y) / reach).min(1.0);
                let strength = (1.0 - away * away).max(0.0) as f32;
                let (step, half) = FLOOR_GRID_M;
                let off = |v: f64| (v / step - (v / step).round()).abs() * step;
                let mut color = if off(p.x) < half || off(p.y) < half {
                    grid
                } else {
                    [0.955, 0.96, 0.968].map(|c| 255.0 * c)
                };
                if self.shadow[at] {
                    color = color.map(|c| SHADOW * c);
                }
                self.pixels[at].color = color.map(|c| 255.0 + strength * (c - 255.0));
            }
        }
    }

    /// The picture with its outlines: red, green, blue of each pixel, row by row.
    pub(super) fn finish(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(3 * self.pixels.len());
        for (at, pixel) in self.pixels.iter().enumerate() {
            let (x, y) = (at % self.width, at / self.width);
            let beside = [(x > 0).then(|| at - 1), (y > 0).then(|| at - self.width)];
            let is_edge = beside.into_iter().flatten().any(|b| self.pixels[b].thing != pixel.thing);
            let dim = if is_edge { OUTLINE } else { 1.0 };
            bytes.extend(pixel.color.map(|c| (dim * c).round().clamp(0.0, 255.0) as u8));
        }
        bytes
    }
}

/// The columns of a row in which weights, given at its first column with their slopes, are all positive.
fn inside(w: &[f64; 3], slopes: &[f64; 3], width: usize) -> Option<std::ops::Range<usize>> {
    let (mut low, mut high) = (0.0_f64, width as f64 - 1.0);
    for (w, slope) in w.iter().zip(slopes) {
        if *slope > 0.0 {
            low = low.max((-w / slope).ceil());
        } else if *slope < 0.0 {
            high = high.min((-w / slope).floor());
        } else if *w < 0.0 {
            return None;
        }
    }
    (low <= high).then(|| low as usize..high as usize + 1)
}

/// Twice the area of a triangle, signed.
fn cross(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Brightness by the cosine between surface and light; the dark side is not all alike.
fn shade(cosine: f64) -> f64 {
    if cosine > 0.0 { AMBIENT + (1.0 - AMBIENT) * cosine } else { AMBIENT * (1.0 + 0.35 * cosine) }
}

fn rgb(color: RGBColor) -> [f32; 3] {
    [color.0, color.1, color.2].map(f32::from)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::planner::SceneShape;
    use std::f64::consts::PI;

    const SIZE: (u32, u32) = (200, 160);

    fn ball(center_m: [f64; 3], radius_m: f64) -> Solid {
        Solid::obstacle(&SceneShape::Sphere { center_m, radius_m })
    }

    fn eye() -> Eye {
        let corners = [-1.0, 1.0].map(|s| Vec3::new(0.0, 1.3 * s, 1.0 + s));
        Eye::fitted(Vec3::new(1.0, 0.0, 0.0), &corners, SIZE)
    }

    #[test]
    fn what_must_be_seen_fills_the_picture_and_stays_inside() {
        for from in [[1.0, 0.2, 0.5], [-0.3, 1.0, 0.1], [0.0, -1.0, 2.0]] {
            let points: Vec<Vec3> = (0..8)
                .map(|i| Vec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)))
                .collect();
            let eye = Eye::fitted(from.into(), &points, SIZE);
            let seen: Vec<[f64; 2]> = points.iter().map(|p| eye.seen(p).0).collect();
            let range = |axis: usize| {
                let all = || seen.iter().map(|s| s[axis]);
                [all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max)]
            };
            let [x, y] = [range(0), range(1)];
            assert!(x[0] > -1e-6 && x[1] < 200.0 + 1e-6 && y[0] > -1e-6 && y[1] < 160.0 + 1e-6);
            // One pair of sides touches the picture's.
            let touches = |[low, high]: [f64; 2], end: f64| low < 1e-6 && high > end - 1e-6;
            assert!(touches(x, 200.0) || touches(y, 160.0), "{x:?} {y:?}");
        }
    }

    #[test]
    fn a_ball_covers_the_disc_of_its_perspective_and_hides_what_is_behind() {
        let eye = eye();
        let (middle, radius) = (Vec3::new(0.0, 0.0, 1.0), 0.6);
        let mut canvas = Canvas::new(eye, SIZE);
        canvas.thing(&[ball([-3.0, 0.0, 1.0], 0.5)], RGBColor(0, 255, 0));
        canvas.thing(&[ball(middle.into(), radius)], RGBColor(255, 0, 0));
        let (_, far) = eye.seen(&middle);
        let disc = eye.scale * radius / (far * far - radius * radius).sqrt();
        let share = canvas.visible(1) as f64 / (PI * disc * disc);
        assert!((0.95..1.01).contains(&share), "{share}");
        assert_eq!(canvas.visible(0), canvas.visible(1), "the farther ball is hidden");
        canvas.floor(Vec3::zeros(), 3.0);
        let bytes = canvas.finish();
        let pixel = |x: usize, y: usize| &bytes[3 * (y * 200 + x)..][..3];
        let [red, green, _] = pixel(100, 80) else { panic!("three channels") };
        assert!(*red > 120 && *green == 0);
        assert_eq!(pixel(2, 2), [255, 255, 255], "nothing above the horizon");
    }

    #[test]
    fn a_shadow_lies_on_the_floor_and_a_veil_covers_only_what_is_not_clear() {
        let corners = [-1.0, 1.0].map(|s| Vec3::new(s, s, 1.0 + s));
        let eye = Eye::fitted(Vec3::new(1.0, 0.0, 1.0), &corners, SIZE);
        let mut canvas = Canvas::new(eye, SIZE);
        canvas.thing(&[ball([0.0, 0.0, 0.5], 0.3)], RGBColor(255, 0, 0));
        assert!(canvas.shadow.iter().any(|s| *s));
        let before: Vec<[f32; 3]> = canvas.pixels.iter().map(|p| p.color).collect();
        canvas.veil(&[ball([0.0, 0.0, 0.5], 0.5)], 0, RGBColor(0, 0, 0), 0.5);
        for (pixel, before) in canvas.pixels.iter().zip(before) {
            assert!(pixel.thing == 0 || pixel.color == before, "the ball is left as it was");
        }
        assert!(canvas.pixels.iter().any(|p| p.thing == 0 && p.color[0] < 140.0));
    }
}
