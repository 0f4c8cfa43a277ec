// What VS Code runs: the language server over pipes, the debug adapter, and a command of its own.
// `make vscode` bundles it into client.js beside this file.
import {
  commands, debug, DebugAdapterExecutable, Uri, ViewColumn, window, workspace,
} from "vscode";
import { LanguageClient, TransportKind } from "vscode-languageclient/node";

const SCHEME = "robot-assistant";
const shown = new Map();
let client;

export async function activate(context) {
  const languages = context.extension.packageJSON.contributes.languages.map((one) => one.id);
  const command = () =>
    workspace.getConfiguration("robotAssistant").get("command") || "robot-assistant";
  const run = { command: command(), args: ["lsp"], transport: TransportKind.stdio };
  client = new LanguageClient("robotAssistant", "Robot Assistant", { run, debug: run }, {
    documentSelector: languages.flatMap((language) => [
      { scheme: "file", language }, { scheme: "untitled", language },
    ]),
    synchronize: { fileEvents: workspace.createFileSystemWatcher("**/*.{toml,cfg,prm}") },
  });
  context.subscriptions.push(
    workspace.registerTextDocumentContentProvider(SCHEME, {
      provideTextDocumentContent: (uri) => shown.get(uri.toString()) ?? "",
    }),
    commands.registerCommand("robotAssistant.showTranslation", () => translate(languages)),
    debug.registerDebugAdapterDescriptorFactory("robot", {
      createDebugAdapterDescriptor: () => new DebugAdapterExecutable(command(), ["debug"]),
    }),
  );
  await client.start();
}

export function deactivate() {
  return client?.stop();
}

async function translate(languages) {
  const editor = window.activeTextEditor;
  if (!editor) return;
  const language = await window.showQuickPick(
    languages.filter((one) => one !== editor.document.languageId),
    { title: "Show this program in" },
  );
  if (!language) return;
  const done = await client.sendRequest("workspace/executeCommand", {
    command: "robot-assistant.translation",
    arguments: [editor.document.uri.toString(), language],
  });
  const [name, text] = Object.entries(done.files)[0] ?? [];
  if (name === undefined) {
    window.showWarningMessage(done.findings[0] ?? "Nothing was written.");
    return;
  }
  const uri = Uri.from({ scheme: SCHEME, path: `/${language}/${name}` });
  shown.set(uri.toString(), text);
  const document = await workspace.openTextDocument(uri);
  await window.showTextDocument(document, { viewColumn: ViewColumn.Beside, preview: true });
}
