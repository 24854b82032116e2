// node validate.js ASSETS: "FILE<tab>CODE,CODE" for every model below ASSETS without a .report.json beside it. See validate.sh.
const fs = require('fs');
const path = require('path');
const validator = require('gltf-validator');

function models(folder) {
    return fs.readdirSync(folder, {withFileTypes: true}).flatMap((entry) => {
        const file = path.join(folder, entry.name);
        if (entry.isDirectory()) return models(file);
        return /\.(gltf|glb)$/.test(entry.name) && !fs.existsSync(file + '.report.json') ? [file] : [];
    });
}

async function errors(file) {
    const read = (uri) => fs.promises.readFile(path.resolve(path.dirname(file), decodeURIComponent(uri))).then((data) => new Uint8Array(data));
    try {
        const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)),
                                                     {uri: path.basename(file), maxIssues: 0, externalResourceFunction: read});
        return [...new Set(report.issues.messages.filter((message) => message.severity === 0).map((message) => message.code))].sort();
    } catch (error) {
        return ['EXCEPTION'];
    }
}

(async () => {
    const root = process.argv[2];
    console.log(`# Errors that the Khronos glTF validator (npm gltf-validator ${validator.version()}) finds in the models of the assets folder.`);
    console.log('# Written by tests/malformed/validate.sh. FILE, then the codes; where a .report.json lies beside the file, that counts.');
    for (const file of models(root).sort()) console.log([path.relative(root, file), (await errors(file)).join(',')].join('\t').trimEnd());
})();
