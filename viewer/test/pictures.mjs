// SPDX-License-Identifier: Apache-2.0
// Numbers of screenshots. The browser itself decodes the PNGs.

/** In the page: the bytes of the pixels of each PNG. */
async function decode(texts) {
  const pictures = [];
  for (const text of texts) {
    const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes], {type: 'image/png'}));
    const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d', {willReadFrequently: true});
    context.drawImage(bitmap, 0, 0);
    pictures.push(context.getImageData(0, 0, bitmap.width, bitmap.height).data);
  }
  return pictures;
}

/** As one text of code: the page's policy lets it make no functions out of texts by itself. */
function decodeIn(page, pngs, evaluate) {
  const texts = JSON.stringify(pngs.map((png) => png.toString('base64')));
  return page.evaluate(`(${decode})(${texts}).then((pictures) => (${evaluate})(...pictures))`);
}

/** deviation: standard deviation of the green values (0-255); colors: distinct colours at 5 bits a channel. */
export function pictureStatistics(page, png) {
  return decodeIn(page, [png], (pixels) => {
    let sum = 0,
      squares = 0;
    const colors = new Set();
    for (let i = 0; i < pixels.length; i += 4) {
      sum += pixels[i + 1];
      squares += pixels[i + 1] ** 2;
      colors.add(((pixels[i] >> 3) << 10) | ((pixels[i + 1] >> 3) << 5) | (pixels[i + 2] >> 3));
    }
    const count = pixels.length / 4;
    return {deviation: Math.sqrt(squares / count - (sum / count) ** 2), colors: colors.size};
  });
}

/** Share of the pixels that differ by more than 12 of 255 in some channel. */
export function comparePictures(page, a, b) {
  return decodeIn(page, [a, b], (pixelsA, pixelsB) => {
    let changed = 0;
    for (let i = 0; i < pixelsA.length; i += 4)
      if ([0, 1, 2].some((k) => Math.abs(pixelsA[i + k] - pixelsB[i + k]) > 12)) ++changed;
    return changed / (pixelsA.length / 4);
  });
}

/** Mean of the rows below that share of the height. */
export function meanColor(page, png, share) {
  return decodeIn(
    page,
    [png],
    `(pixels) => {
    const first = 4 * Math.floor((pixels.length / 4) * ${share});
    const sums = [0, 0, 0];
    for (let i = first; i < pixels.length; i += 4) for (const k of [0, 1, 2]) sums[k] += pixels[i + k];
    const [red, green, blue] = sums.map((sum) => sum / ((pixels.length - first) / 4));
    return {red, green, blue};
  }`,
  );
}

/** Mean difference of the green values of pixels side by side, in the lower half. */
export function fineContrast(page, png) {
  return decodeIn(page, [png], (pixels) => {
    let sum = 0,
      count = 0;
    for (let i = (pixels.length >> 3) << 2; i + 5 < pixels.length; i += 4, ++count)
      sum += Math.abs(pixels[i + 5] - pixels[i + 1]);
    return sum / count;
  });
}
