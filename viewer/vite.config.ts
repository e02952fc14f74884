// SPDX-License-Identifier: Apache-2.0
import {defineConfig} from 'vite';

export default defineConfig({
  base: './',
  build: {
    target: 'es2022',
    chunkSizeWarningLimit: 1500, // three.js alone has 700 kB
  },
  // `npm run dev` takes the site from `orthodrive view DIR --no-open` on its default port.
  server: {proxy: {'/site': 'http://127.0.0.1:8080'}},
});
