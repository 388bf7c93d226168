// Prints the report of the official glTF validator on a file, as JSON: node validate.js PACKAGE FILE
const [, , home, file] = process.argv;
require(home)
  .validateBytes(new Uint8Array(require("fs").readFileSync(file)))
  .then((report) => console.log(JSON.stringify(report)));
